#pragma once

#include <cstddef>
#include <limits>

#include <treelet/core/platform.h>
#include <treelet/query/ray_batch.h>

namespace treelet::cuda {

/// Rays in device memory: arrays of parts, one row for all rays or one a ray.
struct DeviceRayBatch {
  std::size_t size = 0;
  PerRay<Vec3> origins, directions;
  PerRay<float> t_min, t_max;  ///< without values: the two below
  float all_t_min = 0.0f;
  float all_t_max = std::numeric_limits<float>::infinity();

  TREELET_HD Ray operator[](std::size_t i) const {
    return {origins[i], directions[i], t_min.first == nullptr ? all_t_min : t_min[i],
            t_max.first == nullptr ? all_t_max : t_max[i]};
  }
};

}  // namespace treelet::cuda
