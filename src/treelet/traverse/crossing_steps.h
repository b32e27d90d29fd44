#pragma once

#include <cmath>
#include <limits>

#include <treelet/core/exact_steps.h>
#include <treelet/core/platform.h>
#include <treelet/traverse/crossing.h>
#include <treelet/traverse/ray_triangle_steps.h>

// The fill rule of traverse/crossing.h. Host and device call it.

namespace treelet::crossing_steps {

using ray_triangle_steps::ShearedVertex;

TREELET_HD inline int sign(double x) { return (x > 0.0) - (x < 0.0); }

/// By how much q lies beyond p along a sheared axis, 0 or 1: the sign is exact.
TREELET_HD TREELET_NOINLINE inline double sheared_difference(const RayShear& ray, Vec3 p, Vec3 q,
                                                             int axis) {
  const int k = ray.axis[axis], kz = ray.axis[2];
  exact_steps::Expansion sum;
  const auto add = [&](double factor, int along) {
    const exact_steps::TwoTerms difference = exact_steps::two_sum(q[along], -double(p[along]));
    sum.add_product(difference.low, factor, 1.0);
    sum.add_product(difference.high, factor, 1.0);
  };
  add(ray.direction[kz], k);
  add(-double(ray.direction[k]), kz);
  return sum.rounded();
}

/// The sign of edge_function(p, q) for the displaced ray; zero where the edge is parallel to it.
/// `value` is the function in doubles, off by less than `bound`.
TREELET_HD inline int displaced_sign(const RayShear& ray, Vec3 p, Vec3 q, double value,
                                     double bound) {
  if (std::fabs(value) > bound) return sign(value);
  const double exact = ray_triangle_steps::exact_edge_function(ray, p, q);
  if (exact != 0.0) return sign(exact);
  const double difference = sheared_difference(ray, p, q, 1);
  if (difference != 0.0) return sign(difference);
  return -sign(sheared_difference(ray, p, q, 0));
}

/// factor * det(p, q, r); two terms a product of three floats.
TREELET_HD inline void add_determinant(exact_steps::Expansion& sum, double factor, Vec3 p, Vec3 q,
                                       Vec3 r) {
  for (int axis = 0; axis < 3; ++axis) {
    const int next = (axis + 1) % 3, after = (axis + 2) % 3;
    const double scaled = factor * p[axis];
    sum.add_product(scaled, double(q[next]) * r[after], 1.0);
    sum.add_product(-scaled, double(q[after]) * r[next], 1.0);
  }
}

/// det(a - o, b - o, c - o), the sign exact: 48 terms.
TREELET_HD TREELET_NOINLINE inline double exact_volume(Vec3 o, Vec3 a, Vec3 b, Vec3 c) {
  exact_steps::Expansion sum;
  add_determinant(sum, 1.0, a, b, c);
  add_determinant(sum, -1.0, o, b, c);
  add_determinant(sum, -1.0, a, o, c);
  add_determinant(sum, -1.0, a, b, o);
  return sum.rounded();
}

/// A triangle as the ray sees it, in doubles.
struct ShearedTriangle {
  ShearedVertex a, b, c;
  double u, v, w, bound;

  TREELET_HD ShearedTriangle(const RayShear& ray, const Triangle& triangle) {
    using namespace ray_triangle_steps;
    a = shear(ray, triangle.p0);
    b = shear(ray, triangle.p1);
    c = shear(ray, triangle.p2);
    u = edge_function(b, c);
    v = edge_function(c, a);
    w = edge_function(a, b);
    bound = error_bound(ray, a, b, c);
  }
};

/// The common sign of the displaced ray's edge functions; zero where it crosses no such triangle.
TREELET_HD inline int crossed_side(const RayShear& ray, const Triangle& t,
                                   const ShearedTriangle& sheared) {
  const int side = displaced_sign(ray, t.p1, t.p2, sheared.u, sheared.bound);
  if (side == 0 || displaced_sign(ray, t.p2, t.p0, sheared.v, sheared.bound) != side) return 0;
  return displaced_sign(ray, t.p0, t.p1, sheared.w, sheared.bound) == side ? side : 0;
}

/// The exact sign of t = along / (sum dz), where `side` is the sign of sum = U + V + W. Rounding
/// moves along = U Az + V Bz + W Cz by less than z (2 bound + 5u |sum|), for the reasons that
/// traverse_bvh8_blocks.inl has for floats; the error is twice that. Exactly, along is minus the
/// volume of the origin and the triangle times dz^2.
TREELET_HD inline int exact_sign_of_t(const RayShear& ray, const Triangle& t,
                                      const ShearedTriangle& s, int side) {
  constexpr double kSumError = 0x1p-49;  // 16u
  const double along = s.u * s.a.z + s.v * s.b.z + s.w * s.c.z;
  const double z =
      ray_triangle_steps::largest(std::fabs(s.a.z), std::fabs(s.b.z), std::fabs(s.c.z));
  const double error = z * (4.0 * s.bound + kSumError * std::fabs(s.u + s.v + s.w));
  const int sign_of_along =
      std::fabs(along) > error ? sign(along) : -sign(exact_volume(ray.origin, t.p0, t.p1, t.p2));
  return sign_of_along * side * sign(ray.direction[ray.axis[2]]);
}

TREELET_HD inline float with_sign(float t, int sign) {
  constexpr float kTiny = std::numeric_limits<float>::denorm_min();
  if (sign == 0) return 0.0f;
  if (sign > 0) return t > 0.0f ? t : kTiny;
  return t < 0.0f ? t : -kTiny;
}

/// cross of traverse/crossing.h.
TREELET_HD inline bool cross(const RayShear& ray, const Triangle& triangle, TriangleHit& hit) {
  if (!ray_triangle_steps::intersect(ray, triangle, hit)) return false;
  const ShearedTriangle sheared(ray, triangle);
  const int side = crossed_side(ray, triangle, sheared);
  if (side == 0) return false;
  hit.t = with_sign(hit.t, exact_sign_of_t(ray, triangle, sheared, side));
  return true;
}

}  // namespace treelet::crossing_steps
