#pragma once

#include <cmath>

#include <treelet/core/platform.h>
#include <treelet/mesh/mesh.h>

// The distance of a point from a triangle, in doubles, for one triangle or for lanes of them with
// the same bits. Coordinates are taken relative to the point, so nothing is lost far from the
// origin: the error is a few 2^-53 of the distance plus the triangle's size, also for slivers,
// where the edges' differences are exact (coordinates of an axis within a factor of 2^28).
//
// The nearest point lies on an edge, or inside, where the point is over the triangle's plane
// [Ericson2005 s5.1.5]. Differs: what is said of an edge depends on its ends alone, not on the
// triangle or its direction, so that triangles tie exactly where they meet.

namespace treelet::point_steps {

/// Arithmetic of one double; kernels have one of lanes.
struct OneDouble {
  using Number = double;
  static TREELET_INLINE double multiply_add(double a, double b, double c) {
    return std::fma(a, b, c);
  }
  template <class Condition>
  static TREELET_INLINE double select(Condition condition, double yes, double no) {
    return condition ? yes : no;
  }
};

template <class D>
struct Vector {
  D x, y, z;

  friend TREELET_INLINE Vector operator+(const Vector& a, const Vector& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
  }
  friend TREELET_INLINE Vector operator-(const Vector& a, const Vector& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
  }
  friend TREELET_INLINE Vector operator*(const Vector& a, D s) {
    return {a.x * s, a.y * s, a.z * s};
  }
};

using DoubleVector = Vector<double>;

TREELET_INLINE DoubleVector widen(const Vec3& p) { return {p.x, p.y, p.z}; }

template <class D>
TREELET_INLINE D dot(const Vector<D>& a, const Vector<D>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

template <class D>
TREELET_INLINE Vector<D> cross(const Vector<D>& a, const Vector<D>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// a b - c d, off by two roundings of itself however much cancels [JeannerodLouvetMuller2013].
template <class Math, class D>
TREELET_INLINE D difference_of_products(D a, D b, D c, D d) {
  const D cd = c * d;
  const D error = Math::multiply_add(-c, d, cd);
  return Math::multiply_add(a, b, -cd) + error;
}

template <class Math, class D>
TREELET_INLINE Vector<D> accurate_cross(const Vector<D>& a, const Vector<D>& b) {
  return {difference_of_products<Math>(a.y, b.z, a.z, b.y),
          difference_of_products<Math>(a.z, b.x, a.x, b.z),
          difference_of_products<Math>(a.x, b.y, a.y, b.x)};
}

/// An edge seen from the point: vectors to both ends, and from the first to the second.
template <class Math>
struct EdgeView {
  using D = typename Math::Number;
  using V = Vector<D>;
  V begin, end, along;

  /// Where the point is over the edge's line: -1 at its begin, 1 at its end. Swapping the ends
  /// changes the sign and nothing else.
  TREELET_INLINE D place() const { return -(dot(begin + end, along) / dot(along, along)); }

  /// From the point to that place.
  TREELET_INLINE V to_line(D place) const { return ((begin + end) + along * place) * (D{} + 0.5); }

  TREELET_INLINE D squared_distance() const {
    const D t = place();
    const V inner = to_line(t);
    const D one = D{} + 1.0;
    const D within = Math::select(t <= -one, dot(begin, begin), dot(inner, inner));
    return Math::select(t >= one, dot(end, end), within);
  }
};

/// A triangle seen from the point.
template <class Math>
struct TriangleView {
  using D = typename Math::Number;
  using V = Vector<D>;
  V a, b, c;     ///< from the point to the vertices
  V ab, bc, ca;  ///< from vertex to vertex
  V normal;      ///< not of length one

  TREELET_INLINE TriangleView(const V& point, const V& p0, const V& p1, const V& p2)
      : a(p0 - point),
        b(p1 - point),
        c(p2 - point),
        ab(p1 - p0),
        bc(p2 - p1),
        ca(p0 - p2),
        normal(accurate_cross<Math>(ca, ab)) {}

  /// Negative weights of the vertices opposite to the edges, times the squared normal: all are
  /// negative where the point is over the inside.
  TREELET_INLINE D outside_ab() const { return dot(a, cross(normal, ab)); }
  TREELET_INLINE D outside_bc() const { return dot(b, cross(normal, bc)); }
  TREELET_INLINE D outside_ca() const { return dot(c, cross(normal, ca)); }

  TREELET_INLINE D plane_distance() const {  // squared
    const D along_normal = dot(normal, a);
    return along_normal * along_normal / dot(normal, normal);
  }

  TREELET_INLINE D edge_distance() const {  // squared
    const D d_ab = EdgeView<Math>{a, b, ab}.squared_distance();
    const D d_bc = EdgeView<Math>{b, c, bc}.squared_distance();
    const D d_ca = EdgeView<Math>{c, a, ca}.squared_distance();
    const D smaller = Math::select(d_bc < d_ab, d_bc, d_ab);
    return Math::select(d_ca < smaller, d_ca, smaller);
  }

  TREELET_INLINE D squared_distance() const {
    const D zero{};
    const D edges = edge_distance();
    const auto is_over = (outside_ab() < zero) & (outside_bc() < zero) & (outside_ca() < zero);
    const D inside = Math::select(is_over, plane_distance(), edges);
    return Math::select(inside < edges, inside, edges);
  }
};

/// Whether a refit has hidden the triangle (layout/refit_layout.h): no other has equal vertices.
TREELET_HD inline bool is_hidden(const Triangle& triangle) { return triangle.p1 == triangle.p2; }

TREELET_HD inline TriangleView<OneDouble> view_from(Vec3 point, const Triangle& triangle) {
  return {widen(point), widen(triangle.p0), widen(triangle.p1), widen(triangle.p2)};
}

/// The point of a triangle that is nearest to another point.
struct NearestPoint {
  DoubleVector offset;  ///< from the other point
  double u, v;
};

TREELET_HD inline double clamp_to_unit(double x) { return x < 0.0 ? 0.0 : x > 1.0 ? 1.0 : x; }

/// On the edge: its share of the end, and the offset, which is a vertex's at the ends.
struct EdgePoint {
  DoubleVector offset;
  double share;
};
TREELET_HD inline EdgePoint nearest_on(const EdgeView<OneDouble>& edge) {
  const double place = edge.place();
  if (place >= 1.0) return {edge.end, 1.0};
  if (place <= -1.0) return {edge.begin, 0.0};
  return {edge.to_line(place), 0.5 * (1.0 + place)};
}

/// Agrees with squared_distance() about what is nearest.
TREELET_HD inline NearestPoint nearest_point(const TriangleView<OneDouble>& view) {
  const EdgeView<OneDouble> ab{view.a, view.b, view.ab}, bc{view.b, view.c, view.bc},
      ca{view.c, view.a, view.ca};
  const double edges = view.edge_distance();
  if (view.squared_distance() < edges) {
    const double square = dot(view.normal, view.normal);
    const DoubleVector offset = view.normal * (dot(view.normal, view.a) / square);
    return {offset, clamp_to_unit(-view.outside_ca() / square),
            clamp_to_unit(-view.outside_ab() / square)};
  }
  if (ab.squared_distance() == edges) {
    const EdgePoint at = nearest_on(ab);
    return {at.offset, at.share, 0.0};
  }
  if (bc.squared_distance() == edges) {
    const EdgePoint at = nearest_on(bc);
    return {at.offset, 1.0 - at.share, at.share};
  }
  const EdgePoint at = nearest_on(ca);
  return {at.offset, 0.0, 1.0 - at.share};
}

}  // namespace treelet::point_steps
