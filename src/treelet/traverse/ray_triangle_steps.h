#pragma once

#include <cmath>
#include <limits>

#include <treelet/core/exact_steps.h>
#include <treelet/core/platform.h>
#include <treelet/traverse/ray_triangle.h>

// The triangle test's steps 2 and 3; see traverse/ray_triangle.h. Host and device call them.

namespace treelet::ray_triangle_steps {

constexpr double kDoubleEdgeError = 0x1p-48;  // 32u, for u = 2^-53
/// Error bounds in a sum from which on its error moves a hit by less than 2^-24 of the reach.
constexpr double kAccurateSum = 0x1p26;

TREELET_HD inline double largest(double a, double b, double c) {
  const double d = a < b ? b : a;
  return d < c ? c : d;
}
TREELET_HD inline double smallest(double a, double b, double c) {
  const double d = b < a ? b : a;
  return c < d ? c : d;
}

TREELET_HD inline void set_up(RayShear& shear, const Ray& ray) {
  const Vec3 direction = ray.direction;
  shear.origin = ray.origin;
  shear.direction = direction;
  const float x = std::fabs(direction.x), y = std::fabs(direction.y), z = std::fabs(direction.z);
  const int largest = x > y ? (x > z ? 0 : 2) : (y > z ? 1 : 2);
  shear.axis[0] = (largest + 1) % 3;
  shear.axis[1] = (largest + 2) % 3;
  shear.axis[2] = largest;
  shear.shear_x = direction[shear.axis[0]] / direction[largest];
  shear.shear_y = direction[shear.axis[1]] / direction[largest];
}

/// A vertex relative to the ray's origin, sheared and scaled by the direction's z: x and y need no
/// division, and are exact for coordinates of few bits.
struct ShearedVertex {
  double x, y, z;
};

TREELET_HD inline ShearedVertex shear(const RayShear& ray, Vec3 vertex) {
  const auto [kx, ky, kz] = ray.axis;
  const double x = double(vertex[kx]) - ray.origin[kx];
  const double y = double(vertex[ky]) - ray.origin[ky];
  const double z = double(vertex[kz]) - ray.origin[kz];
  const double dx = ray.direction[kx], dy = ray.direction[ky], dz = ray.direction[kz];
  return {x * dz - z * dx, y * dz - z * dy, z};
}

TREELET_HD inline double edge_function(const ShearedVertex& p, const ShearedVertex& q) {
  return q.x * p.y - q.y * p.x;
}

/// Rounding moves a sheared coordinate by less than 4u z + 3u m, and an edge function by less than
/// 16u m (m + z), to first order, with u = 2^-53 and z scaled like x and y; the bound is twice
/// that.
TREELET_HD inline double error_bound(const RayShear& ray, const ShearedVertex& a,
                                     const ShearedVertex& b, const ShearedVertex& c) {
  const double m = largest(largest(std::fabs(a.x), std::fabs(a.y), std::fabs(b.x)), std::fabs(b.y),
                           largest(std::fabs(c.x), std::fabs(c.y), 0.0));
  const double z = largest(std::fabs(a.z), std::fabs(b.z), std::fabs(c.z)) *
                   std::fabs(double(ray.direction[ray.axis[2]]));
  return kDoubleEdgeError * m * (m + z);
}

/// Edge function of q and p with the exact sign: the triple product times the direction's z.
TREELET_HD inline double exact_edge_function(const RayShear& ray, Vec3 p, Vec3 q) {
  const auto [kx, ky, kz] = ray.axis;
  const auto permute = [&](Vec3 v) { return Vec3{v[kx], v[ky], v[kz]}; };
  return ray.direction[kz] * exact_steps::triple_product(permute(ray.direction),
                                                         permute(ray.origin), permute(q),
                                                         permute(p));
}

TREELET_HD inline bool all_same_sign(double u, double v, double w) {
  return (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
}

/// intersect_exactly of traverse/ray_triangle.h.
TREELET_HD inline bool intersect(const RayShear& ray, const Triangle& triangle, TriangleHit& hit) {
  constexpr double inf = std::numeric_limits<double>::infinity();
  const ShearedVertex a = shear(ray, triangle.p0);
  const ShearedVertex b = shear(ray, triangle.p1);
  const ShearedVertex c = shear(ray, triangle.p2);
  double u = edge_function(b, c), v = edge_function(c, a), w = edge_function(a, b);
  const double bound = error_bound(ray, a, b, c);
  if (smallest(u, v, w) < -bound && largest(u, v, w) > bound) return false;
  // Also where all three are small: seen nearly edge-on, signs may be right and t, u, v far off.
  const double needed = std::fabs(u + v + w) > kAccurateSum * bound ? bound : inf;
  if (!(std::fabs(u) > needed)) u = exact_edge_function(ray, triangle.p1, triangle.p2);
  if (!(std::fabs(v) > needed)) v = exact_edge_function(ray, triangle.p2, triangle.p0);
  if (!(std::fabs(w) > needed)) w = exact_edge_function(ray, triangle.p0, triangle.p1);
  const double sum = u + v + w;
  if (!all_same_sign(u, v, w) || sum == 0.0) return false;
  const double dz = ray.direction[ray.axis[2]];
  hit.t = float((u * a.z + v * b.z + w * c.z) / (sum * dz)) + 0.0f;  // -0 to +0
  hit.u = float(v / sum) + 0.0f;
  hit.v = float(w / sum) + 0.0f;
  return true;
}

}  // namespace treelet::ray_triangle_steps
