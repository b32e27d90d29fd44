#pragma once

#include <cstddef>
#include <cstdint>
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
  /// Thread k traces ray order[k]; null: ray k. Answers lie in the places of their rays.
  const std::uint32_t* order = nullptr;

  TREELET_HD std::size_t ray_of(std::size_t thread) const {
    return order == nullptr ? thread : order[thread];
  }

  TREELET_HD Ray operator[](std::size_t i) const {
    return {origins[i], directions[i], t_min.first == nullptr ? all_t_min : t_min[i],
            t_max.first == nullptr ? all_t_max : t_max[i]};
  }

  /// `count` rays from one on, in no other order than they have.
  DeviceRayBatch part(std::size_t begin, std::size_t count) const {
    DeviceRayBatch rays = *this;
    rays.size = count;
    rays.origins = origins.from(begin);
    rays.directions = directions.from(begin);
    rays.t_min = t_min.from(begin);
    rays.t_max = t_max.from(begin);
    rays.order = nullptr;
    return rays;
  }
};

}  // namespace treelet::cuda
