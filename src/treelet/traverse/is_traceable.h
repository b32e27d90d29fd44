#pragma once

#include <treelet/core/platform.h>
#include <treelet/core/ray.h>

namespace treelet {

/// Whether a ray can hit anything: finite origin and direction, a direction that is not zero, and
/// limits that are no NaN and in order. Other rays miss.
TREELET_HD inline bool is_traceable(const Ray& ray) {
  const float sum = ray.origin.x * 0.0f + ray.origin.y * 0.0f + ray.origin.z * 0.0f +
                    ray.direction.x * 0.0f + ray.direction.y * 0.0f + ray.direction.z * 0.0f;
  const bool is_finite = sum == 0.0f;  // infinity and NaN times zero are NaN
  return is_finite && ray.direction != Vec3{0, 0, 0} && ray.t_min <= ray.t_max;
}

}  // namespace treelet
