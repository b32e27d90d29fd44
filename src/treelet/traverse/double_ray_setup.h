#pragma once

#include <cstdint>
#include <limits>

#include <treelet/core/aabb.h>
#include <treelet/core/double_ray.h>
#include <treelet/core/platform.h>
#include <treelet/mesh/double_boxes.h>

namespace treelet {

/// What the slab test needs of a ray in doubles: RayBox (traverse/ray_box.h) in the boxes' frame.
/// There the scene is about one large, so that no float overflows but far away, where infinity and
/// NaN clip nothing. The bounds on rounding are those of RayBox; besides, the ray's start is always
/// rounded to floats, and coming to the frame takes 2^-51 of the distance at most, both of which it
/// has for a start that was moved.
struct DoubleRayBox {
  float start[3];
  float inverse[3];   ///< of the direction, whose largest component is in [1, 2)
  float padding;      ///< of planes along each axis
  double t_scale[2];  ///< slab t of a ray's t: times both, less the shift
  double t_shift;

  // Limits on the ray's t as limits on slab t, wider by what doubles round: t itself, of a hit, may
  // have been rounded to a denormal.
  TREELET_INLINE float lower_limit(double t) const {
    return -upper(-((t - kTiny) * t_scale[0] * t_scale[1]), -t_shift);
  }
  TREELET_INLINE float upper_limit(double t) const {
    return upper((t + kTiny) * t_scale[0] * t_scale[1], t_shift);
  }

  static constexpr double kTiny = std::numeric_limits<double>::denorm_min();

 private:
  static TREELET_INLINE float upper(double time, double shift) {
    constexpr double kLargest = std::numeric_limits<float>::max();
    const double size = (time < 0.0 ? -time : time) + (shift < 0.0 ? -shift : shift);
    const double limit = time - shift + (size * 0x1p-50 + 0x1p-140);
    if (!(limit < kLargest)) return std::numeric_limits<float>::max();  // also for NaN
    return limit > -kLargest ? float(limit) : -std::numeric_limits<float>::max();
  }
};

/// A ray in doubles, prepared for boxes and triangles. Axes are permuted as in RayShear; the unit
/// direction is the ray's, scaled by a power of two to a largest component in [1, 2), so that
/// products of it seldom over- or underflow.
struct DoubleRaySetup {
  DoubleRayBox box;
  const DoubleRay* ray;
  int axis[3];
  double origin[3], unit[3];
  double z_of_t;        ///< the size of the direction's z: t times it is a distance along z
  double z_min, z_max;  ///< no hit within the limits on t is outside of these,
  double inner_z_min, inner_z_max;  ///< and none certainly inside of these is outside of them

  void set_lower_limit(double t) {
    z_min = (t - DoubleRayBox::kTiny) * z_of_t - kSmallest;
    inner_z_min = (t + DoubleRayBox::kTiny) * z_of_t + kSmallest;
  }
  TREELET_INLINE void set_upper_limit(double t) {
    z_max = (t + DoubleRayBox::kTiny) * z_of_t + kSmallest;
    inner_z_max = (t - DoubleRayBox::kTiny) * z_of_t - kSmallest;
    if (!(inner_z_max < kLarge)) inner_z_max = kLarge;  // infinity would be certain of nothing
    if (!(inner_z_max < kLarge * z_of_t)) inner_z_max = kLarge * z_of_t;  // t stays finite
  }

 private:
  static constexpr double kSmallest = 0x1p-1000;  // more than underflow takes
  static constexpr double kLarge = 0x1p900;
};

/// False where the ray can hit nothing: as is_traceable(Ray).
bool prepare(const DoubleRay& ray, const BoxFrame& frame, const Aabb& scene, DoubleRaySetup& setup);

}  // namespace treelet
