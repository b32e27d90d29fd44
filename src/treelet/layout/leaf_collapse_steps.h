#pragma once

#include <cstdint>

#include <treelet/tree/sah.h>

namespace treelet {

/// Whether a subtree becomes one leaf, and what it then costs.
struct LeafDecision {
  float cost;
  bool is_leaf;
};

/// The step of the leaf collapse, which host and device loop over: a leaf where that is no dearer
/// than the subtree [KarrasAila2013 s3.1].
TREELET_HD constexpr LeafDecision decide_leaf(float half_area, float children_cost,
                                              std::uint32_t triangles, const SahModel& sah) {
  const float internal = sah.internal_cost(half_area, children_cost);
  const float leaf = sah.leaf_cost(half_area, triangles);
  return {min(internal, leaf), leaf <= internal};
}

}  // namespace treelet
