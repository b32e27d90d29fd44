#pragma once

#include <cmath>
#include <limits>

#include <treelet/core/ray.h>
#include <treelet/mesh/mesh.h>

// Exact ray-triangle test: a hit is reported if and only if the ray, as given in floats, meets the
// triangle, as given in floats; so no ray slips between triangles that share an edge or a vertex,
// and no triangle is hit from outside its box.
//
// As in [WoopBenthinWald2013], vertices are moved to the ray's origin and sheared until the ray is
// the z axis. The signs of three edge functions then tell inside from outside:
//
//     U = Cx By - Cy Bx      V = Ax Cy - Ay Cx      W = Bx Ay - By Ax
//
// Differs: they call a sign right if rounding treats both triangles of an edge alike. Here signs
// are right, in three steps, each for the few that the one before leaves undecided:
//   1. floats with an error bound reject nearly all triangles that are missed;
//   2. doubles with an error bound decide nearly all others and give t, u, v;
//   3. exact expansions decide rays through an edge or a vertex (core/exact.h).

namespace treelet {

/// What the triangle test needs of a ray. Axes are permuted so that z is the largest component.
struct RayShear {
  Vec3 origin, direction;
  int axis[3];
  float shear_x, shear_y;

  /// For the device, which calls ray_triangle_steps::set_up next.
  RayShear() = default;
  /// The direction must be finite and not zero, the origin finite.
  explicit RayShear(const Ray& ray);
};

/// Bound on the rounding of a float edge function, over the square of the triangle's sheared size;
/// see may_intersect.
inline constexpr float kEdgeError = 0x1p-19f;  // 32u
inline constexpr float kSmallestNormal = std::numeric_limits<float>::min();

/// A hit before it is known to be the one that is looked for.
struct TriangleHit {
  float t, u, v;
};

/// Steps 2 and 3. Returns whether the ray's whole line meets the triangle; a triangle seen edge-on
/// is not met. t is infinite where it exceeds the largest float.
bool intersect_exactly(const RayShear& ray, const Triangle& triangle, TriangleHit& hit);

/// Step 1: false only where the line certainly misses.
///
/// With u = 2^-24, z the largest |z| and m the largest sheared |x| or |y| of a vertex, rounding
/// moves a sheared coordinate by less than 4u z + 2u m, and an edge function by less than 16u m z +
/// 12u m^2 (to first order). The bound is twice that, plus the smallest normal float for products
/// that underflow.
TREELET_HD inline bool may_intersect(const RayShear& ray, const Triangle& triangle) {
  const auto [kx, ky, kz] = ray.axis;
  const Vec3 a = triangle.p0 - ray.origin, b = triangle.p1 - ray.origin,
             c = triangle.p2 - ray.origin;
  const float ax = a[kx] - ray.shear_x * a[kz], ay = a[ky] - ray.shear_y * a[kz];
  const float bx = b[kx] - ray.shear_x * b[kz], by = b[ky] - ray.shear_y * b[kz];
  const float cx = c[kx] - ray.shear_x * c[kz], cy = c[ky] - ray.shear_y * c[kz];
  const float u = cx * by - cy * bx;
  const float v = ax * cy - ay * cx;
  const float w = bx * ay - by * ax;
  const float m = max(max(max(std::fabs(ax), std::fabs(ay)), max(std::fabs(bx), std::fabs(by))),
                      max(std::fabs(cx), std::fabs(cy)));
  const float z = max(std::fabs(a[kz]), max(std::fabs(b[kz]), std::fabs(c[kz])));
  const float bound = kEdgeError * (m * (m + z)) + kSmallestNormal;
  // Where a product overflows, so does m * (m + z), and an infinite bound or NaN rejects nothing.
  return !(min(u, min(v, w)) < -bound && max(u, max(v, w)) > bound);
}

inline bool intersect(const RayShear& ray, const Triangle& triangle, TriangleHit& hit) {
  return may_intersect(ray, triangle) && intersect_exactly(ray, triangle, hit);
}

}  // namespace treelet
