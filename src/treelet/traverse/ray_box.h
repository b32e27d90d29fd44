#pragma once

#include <treelet/core/aabb.h>
#include <treelet/core/platform.h>
#include <treelet/core/ray.h>

// Slab test that never loses a box which the exact ray meets.
//
// Let u = 2^-24, half an ulp of 1, and R the largest distance, along any axis, from the origin to a
// side of the scene. Rounding moves a slab's plane along its axis by less than 5u R: u each for the
// difference, the reciprocal, the product, the padding and the limit it is compared with. A
// direction component below 2^-22 of the largest is raised to that, which moves the ray by 4u R at
// most over the scene. So both planes are moved apart by 16u R. The ray brings this padding, the
// boxes stay exact, and a ray from far away, whose own rounding is larger, gets more. Differs from
// [Ize2013], who scales t_far alone: that loses ties in t and negative t.

namespace treelet {

/// What the slab test needs of a ray. It measures t in units of 2^k directions such that the
/// largest component is in [1, 2): no reciprocal overflows, however long the direction.
struct RayBox {
  float origin[3];
  float inverse[3];
  float padding[3];  ///< in slab t
  bool points_down[3];
  double t_scale;  ///< slab t over the ray's t

  RayBox(const Ray& ray, const Aabb& scene);

  /// A limit on the ray's t as a limit on slab t.
  TREELET_INLINE float to_slab(float t) const { return float(t * t_scale); }
};

/// Where a ray enters and leaves a box, in slab t; it misses where near > far.
struct BoxSpan {
  float near, far;

  bool is_hit() const { return near <= far; }
};

/// Clips [t_min, t_max], in slab t, to the box. NaN, from coordinates near the largest float, clips
/// nothing.
inline BoxSpan intersect(const RayBox& ray, const Aabb& box, float t_min, float t_max) {
  BoxSpan span{t_min, t_max};
  for (int axis = 0; axis < 3; ++axis) {
    const bool down = ray.points_down[axis];
    const float near_plane = down ? box.upper[axis] : box.lower[axis];
    const float far_plane = down ? box.lower[axis] : box.upper[axis];
    const float near = (near_plane - ray.origin[axis]) * ray.inverse[axis] - ray.padding[axis];
    const float far = (far_plane - ray.origin[axis]) * ray.inverse[axis] + ray.padding[axis];
    span.near = near > span.near ? near : span.near;
    span.far = far < span.far ? far : span.far;
  }
  return span;
}

}  // namespace treelet
