#pragma once

#include <cstdint>
#include <limits>

#include <treelet/core/platform.h>
#include <treelet/core/vec.h>

namespace treelet {

/// The surface area heuristic: expected cost of a random ray, in triangle tests. Builders,
/// optimizers, leaf collapse and statistics all take their costs from here. Constants as in
/// [KarrasAila2013 s3].
struct SahModel {
  float traversal_cost = 1.2f;     ///< of an internal node
  float intersection_cost = 1.0f;  ///< of a triangle
  std::uint32_t leaf_limit = 8;    ///< triangles a leaf of the layout can hold

  TREELET_HD constexpr float internal_cost(float half_area, float children_cost) const {
    return traversal_cost * half_area + children_cost;
  }
  TREELET_HD constexpr float leaf_cost(float half_area, std::uint32_t count) const {
    if (count > leaf_limit) return std::numeric_limits<float>::infinity();
    return intersection_cost * half_area * float(count);
  }
  /// A subtree becomes one leaf where that is cheaper [KarrasAila2013 s3.1].
  TREELET_HD constexpr float subtree_cost(float half_area, float children_cost,
                                          std::uint32_t count) const {
    return min(internal_cost(half_area, children_cost), leaf_cost(half_area, count));
  }
};

}  // namespace treelet
