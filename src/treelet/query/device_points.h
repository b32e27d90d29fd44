#pragma once

#include <cstddef>
#include <limits>

#include <treelet/core/platform.h>
#include <treelet/query/ray_batch.h>

namespace treelet::cuda {

/// Points in device memory, one radius for all or one each.
struct DevicePointBatch {
  std::size_t size = 0;
  PerRay<Vec3> points;
  PerRay<float> radii;  ///< without values: the one below
  float all_radii = std::numeric_limits<float>::infinity();

  TREELET_HD float radius(std::size_t i) const {
    return radii.first == nullptr ? all_radii : radii[i];
  }
};

}  // namespace treelet::cuda
