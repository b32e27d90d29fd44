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
// boxes stay exact.
//
// For an origin far outside the scene, R would make the padding larger than the scene's details.
// The slab test then starts at another point of the ray, near the scene; rounding that point to
// floats costs another u of its coordinates, finding it in doubles 2^-52 R. Limits on t, which were
// rounded when t was large, are widened by an ulp.
//
// Differs from [Ize2013], who scales t_far alone: that loses ties in t and negative t.

namespace treelet {

/// Slab t of a ray's t.
struct SlabTime {
  double t_shift = 0.0;  ///< the ray's t at the slab test's origin
  double t_scale = 1.0;  ///< slab t over the ray's t

  // Limits on the ray's t as limits on slab t, an ulp wider. A limit that a t beyond the largest
  // float was rounded to stands for all of these.
  TREELET_INLINE float lower_limit(float t) const {
    const float low = t > kLargest ? kLargest : t;
    return float((low - ulp(low) - t_shift) * t_scale);
  }
  TREELET_INLINE float upper_limit(float t) const {
    const float high = t < -kLargest ? -kLargest : t;
    return float((high + ulp(high) - t_shift) * t_scale);
  }

 private:
  static constexpr float kLargest = 0x1.fffffep127f;

  /// At least one, also of a denormal.
  static TREELET_INLINE double ulp(float t) {
    return (t < 0.0f ? -double(t) : double(t)) * 0x1p-23 + 0x1p-149;
  }
};

/// What the slab test needs of a ray. It measures t from its own origin in units of 2^k directions
/// such that the largest component is in [1, 2): no reciprocal overflows, however long the
/// direction.
struct RayBox : SlabTime {
  float origin[3];
  float inverse[3];
  float padding[3];  ///< in slab t
  bool points_down[3];

  /// For the device, which calls ray_box_steps::set_up next.
  RayBox() = default;
  RayBox(const Ray& ray, const Aabb& scene);
};

/// Where a ray enters and leaves a box, in slab t; it misses where enter > leave.
struct BoxSpan {
  float enter, leave;

  TREELET_HD bool is_hit() const { return enter <= leave; }
};

/// Clips [t_min, t_max], in slab t, to the box. NaN, from coordinates near the largest float, clips
/// nothing.
TREELET_HD inline BoxSpan intersect(const RayBox& ray, const Aabb& box, float t_min, float t_max) {
  BoxSpan span{t_min, t_max};
  for (int axis = 0; axis < 3; ++axis) {
    const bool down = ray.points_down[axis];
    const float near_plane = down ? box.upper[axis] : box.lower[axis];
    const float far_plane = down ? box.lower[axis] : box.upper[axis];
    const float near_t = (near_plane - ray.origin[axis]) * ray.inverse[axis] - ray.padding[axis];
    const float far_t = (far_plane - ray.origin[axis]) * ray.inverse[axis] + ray.padding[axis];
    span.enter = near_t > span.enter ? near_t : span.enter;
    span.leave = far_t < span.leave ? far_t : span.leave;
  }
  return span;
}

}  // namespace treelet
