#include <treelet/traverse/double_triangle.h>

#include <algorithm>
#include <cmath>

#include <treelet/core/double_double.h>
#include <treelet/core/wide_integer.h>

namespace treelet {
namespace {

int sign(double x) { return (x > 0.0) - (x < 0.0); }

/// The exponent at which all coordinates of some vectors are whole.
template <class... Vectors>
int common_exponent(const Vectors&... vectors) {
  int exponent = 1024;
  for (const DoubleVec3& v : {vectors...}) {
    for (int axis = 0; axis < 3; ++axis) exponent = std::min(exponent, lowest_bit(v[axis]));
  }
  return exponent;
}

struct WideVector {
  WideInteger xyz[3];

  WideVector(const DoubleVec3& v, int exponent) {
    for (int axis = 0; axis < 3; ++axis) xyz[axis] = WideInteger(v[axis], exponent);
  }
};

WideVector operator-(WideVector a, const WideVector& b) {
  for (int axis = 0; axis < 3; ++axis) a.xyz[axis] = a.xyz[axis] - b.xyz[axis];
  return a;
}

WideInteger triple_product(const WideVector& a, const WideVector& p, const WideVector& q) {
  return treelet::triple_product(a.xyz, p.xyz, q.xyz);
}

/// The sign of direction . ((q - origin) x (p - origin)).
int exact_edge_sign(const DoubleRay& ray, const DoubleVec3& p, const DoubleVec3& q) {
  const int exponent = common_exponent(ray.origin, p, q);
  const WideVector origin(ray.origin, exponent);
  const WideVector direction(ray.direction, common_exponent(ray.direction));
  return triple_product(direction, WideVector(q, exponent) - origin,
                        WideVector(p, exponent) - origin)
      .sign();
}

/// The sign of how far q lies beyond p along sheared axis k, times the direction's z.
int exact_difference_sign(const DoubleRay& ray, const DoubleVec3& p, const DoubleVec3& q, int k,
                          int kz) {
  const int exponent = common_exponent(p, q);
  const WideVector along = WideVector(q, exponent) - WideVector(p, exponent);
  const WideVector direction(ray.direction, common_exponent(ray.direction));
  return (along.xyz[k] * direction.xyz[kz] - along.xyz[kz] * direction.xyz[k]).sign();
}

/// A triangle as the ray sees it; U, V, W of traverse/ray_triangle.h are edge functions 0, 1, 2.
struct ShearedDoubles {
  struct Vertex {
    double x, y, z;
  };
  double edge[3], bound;

  ShearedDoubles(const DoubleRaySetup& ray, const DoubleTriangle& triangle) {
    const Vertex a = shear(ray, triangle.p0), b = shear(ray, triangle.p1),
                 c = shear(ray, triangle.p2);
    edge[0] = c.x * b.y - c.y * b.x;
    edge[1] = a.x * c.y - a.y * c.x;
    edge[2] = b.x * a.y - b.y * a.x;
    double m = 0.0, z = 0.0;
    for (const Vertex& v : {a, b, c}) {
      m = std::max({m, std::fabs(v.x), std::fabs(v.y)});
      z = std::max(z, std::fabs(v.z * ray.unit[2]));
    }
    bound = kDoubleEdgeBound * m * (m + z) + kUnderflow;
  }

  /// Zero where doubles cannot tell; NaN never can.
  int sign_of(int i) const { return std::fabs(edge[i]) > bound ? sign(edge[i]) : 0; }

 private:
  static Vertex shear(const DoubleRaySetup& ray, const DoubleVec3& vertex) {
    const double x = vertex[ray.axis[0]] - ray.origin[0];
    const double y = vertex[ray.axis[1]] - ray.origin[1];
    const double z = vertex[ray.axis[2]] - ray.origin[2];
    return {x * ray.unit[2] - z * ray.unit[0], y * ray.unit[2] - z * ray.unit[1], z};
  }
};

/// The two ends of the edge opposite to a corner.
struct Edge {
  const DoubleVec3 &p, &q;
};
Edge edge_of(const DoubleTriangle& t, int i) {
  return i == 0 ? Edge{t.p1, t.p2} : i == 1 ? Edge{t.p2, t.p0} : Edge{t.p0, t.p1};
}

int edge_sign(const DoubleRaySetup& setup, const ShearedDoubles& sheared, const Edge& edge, int i) {
  const int certain = sheared.sign_of(i);
  return certain != 0 ? certain : exact_edge_sign(*setup.ray, edge.p, edge.q) * sign(setup.unit[2]);
}

/// The same for the displaced ray; zero where the edge is parallel to it.
int displaced_sign(const DoubleRaySetup& setup, const ShearedDoubles& sheared, const Edge& edge,
                   int i) {
  const int exact = edge_sign(setup, sheared, edge, i);
  if (exact != 0) return exact;
  const auto difference = [&](int k) {
    return exact_difference_sign(*setup.ray, edge.p, edge.q, setup.axis[k], setup.axis[2]);
  };
  const int along_y = difference(1);
  return along_y != 0 ? along_y : -difference(0);
}

}  // namespace

bool meets(const DoubleRaySetup& setup, const DoubleTriangle& triangle) {
  const ShearedDoubles sheared(setup, triangle);
  bool has_negative = false, has_positive = false;
  for (int i = 0; i < 3; ++i) {
    const int side = edge_sign(setup, sheared, edge_of(triangle, i), i);
    has_negative |= side < 0;
    has_positive |= side > 0;
    if (has_negative && has_positive) return false;
  }
  return has_negative || has_positive;
}

bool crosses(const DoubleRaySetup& setup, const DoubleTriangle& triangle) {
  const ShearedDoubles sheared(setup, triangle);
  const int side = displaced_sign(setup, sheared, edge_of(triangle, 0), 0);
  if (side == 0) return false;
  return displaced_sign(setup, sheared, edge_of(triangle, 1), 1) == side &&
         displaced_sign(setup, sheared, edge_of(triangle, 2), 2) == side;
}

double place_exactly(const DoubleRay& ray, const DoubleTriangle& triangle, Place place) {
  const int exponent = common_exponent(ray.origin, triangle.p0, triangle.p1, triangle.p2);
  const int direction_exponent = common_exponent(ray.direction);
  const WideVector corner(triangle.p0, exponent);
  const WideVector to_corner = corner - WideVector(ray.origin, exponent);
  const WideVector first = WideVector(triangle.p1, exponent) - corner;
  const WideVector second = WideVector(triangle.p2, exponent) - corner;
  const WideVector direction(ray.direction, direction_exponent);
  const WideInteger volume = triple_product(direction, first, second);
  switch (place) {
    case Place::u:
      return quotient(triple_product(to_corner, direction, second), volume, 0);
    case Place::v:
      return quotient(triple_product(to_corner, first, direction), volume, 0);
    case Place::t:
      break;
  }
  return quotient(triple_product(to_corner, first, second), volume, exponent - direction_exponent);
}

}  // namespace treelet
