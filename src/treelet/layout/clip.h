#pragma once

#include <array>
#include <cmath>

#include <treelet/core/aabb.h>
#include <treelet/mesh/mesh.h>

namespace treelet {

/// A convex polygon in double: a triangle clipped by the six planes of a box, so at most
/// 3 + 6 vertices.
struct ClippedTriangle {
  using Point = std::array<double, 3>;

  std::array<Point, 9> vertex;
  int size = 0;

  TREELET_HD explicit ClippedTriangle(const Triangle& t)
      : vertex{to_double(t.p0), to_double(t.p1), to_double(t.p2)}, size(3) {}

  /// Keeps what lies inside the box. May leave nothing.
  TREELET_HD void clip(const Aabb& box) {
    for (int axis = 0; axis < 3; ++axis) {
      clip_plane(axis, box.lower[axis], 1.0);
      clip_plane(axis, box.upper[axis], -1.0);
    }
  }

  TREELET_HD double area() const {
    Point sum{0, 0, 0};
    for (int i = 1; i + 1 < size; ++i) {
      Point a, b;
      for (int axis = 0; axis < 3; ++axis) {
        a[axis] = vertex[i][axis] - vertex[0][axis];
        b[axis] = vertex[i + 1][axis] - vertex[0][axis];
      }
      for (int axis = 0; axis < 3; ++axis) {
        const int next = (axis + 1) % 3, after = (axis + 2) % 3;
        sum[axis] += a[next] * b[after] - a[after] * b[next];
      }
    }
    return 0.5 * std::sqrt(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]);
  }

 private:
  TREELET_HD static Point to_double(Vec3 p) { return {p.x, p.y, p.z}; }

  TREELET_HD static Point point_on_plane(const Point& a, const Point& b, int axis,
                                         double position) {
    const double s = (position - a[axis]) / (b[axis] - a[axis]);
    Point p;
    for (int i = 0; i < 3; ++i) p[i] = a[i] + s * (b[i] - a[i]);
    p[axis] = position;
    return p;
  }

  /// Keeps side * (x - position) >= 0 [SutherlandHodgman1974].
  TREELET_HD void clip_plane(int axis, double position, double side) {
    const auto inside = [&](const Point& p) { return side * (p[axis] - position) >= 0.0; };
    int inside_count = 0;
    for (int i = 0; i < size; ++i) inside_count += inside(vertex[i]);
    if (inside_count == size) return;
    std::array<Point, 2 * 9> kept;  // rounding can bend a sliver inwards: two a vertex at worst
    int count = 0;
    for (int i = 0; i < size; ++i) {
      const Point& a = vertex[i];
      const Point& b = vertex[i + 1 < size ? i + 1 : 0];
      if (inside(a)) kept[count++] = a;
      if (inside(a) != inside(b)) kept[count++] = point_on_plane(a, b, axis, position);
    }
    size = count < int(vertex.size()) ? count : int(vertex.size());
    for (int i = 0; i < size; ++i) vertex[i] = kept[i];
  }
};

}  // namespace treelet
