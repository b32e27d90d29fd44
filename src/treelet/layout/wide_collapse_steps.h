#pragma once

#include <cstdint>
#include <limits>

#include <treelet/layout/bvh8.h>
#include <treelet/layout/wide_collapse.h>

// What one node does in the wide collapse [YlitieKarrasLaine2017 s3.1]; host and device loop over
// it.

namespace treelet {

TREELET_HD constexpr std::uint32_t blocks_for(
    std::uint32_t triangles, std::uint32_t block_size = TriangleBlock::kTriangles) {
  return triangles / block_size + (triangles % block_size != 0);
}

TREELET_HD constexpr float wide_leaf_cost(float half_area, std::uint32_t triangles,
                                          const WideCostModel& model) {
  if (triangles > model.leaf_limit) return std::numeric_limits<float>::infinity();
  return model.block_cost * half_area * float(blocks_for(triangles, model.block_size));
}

/// The choice of a leaf of the binary tree.
TREELET_HD constexpr WideChoice choose_leaf(float half_area, const WideCostModel& model) {
  WideChoice choice{WideDecision::leaf(), {}};
  for (float& cost : choice.costs) cost = wide_leaf_cost(half_area, 1, model);
  return choice;
}

struct WideShares {
  float cost;
  int left;
};

/// The cheapest way to share `children` children out to the two sides.
TREELET_HD constexpr WideShares distribute(const WideChoice& left, const WideChoice& right,
                                           int children) {
  WideShares best{std::numeric_limits<float>::infinity(), 1};
  for (int share = 1; share < children; ++share) {
    const float cost = left.cost(share) + right.cost(children - share);
    if (cost < best.cost) best = {cost, share};
  }
  return best;
}

/// The choice of an internal node of so many triangles after its children's.
TREELET_HD constexpr WideChoice choose_internal(float half_area, std::uint32_t triangles,
                                                const WideChoice& left, const WideChoice& right,
                                                const WideCostModel& model) {
  constexpr int kWidth = WideChoice::kWidth;
  WideChoice choice{};
  const WideShares below = distribute(left, right, kWidth);
  const float as_leaf = wide_leaf_cost(half_area, triangles, model);
  const float as_node = model.node_cost * half_area + below.cost;
  const bool is_leaf = as_leaf <= as_node;
  const float as_one = is_leaf ? as_leaf : as_node;
  choice.decision.is_leaf = is_leaf;
  choice.decision.set_left_share(kWidth, below.left);
  unsigned stays_whole = 1 << 1;
  choice.set_cost(1, as_one);
  for (int children = 2; children < kWidth; ++children) {
    const WideShares spread = distribute(left, right, children);
    const bool whole = as_one < spread.cost;  // of equal costs, the fuller node
    choice.set_cost(children, whole ? as_one : spread.cost);
    choice.decision.set_left_share(children, spread.left);
    stays_whole |= unsigned(whole) << children;
  }
  choice.decision.stays_whole = stays_whole & 0xff;
  return choice;
}

/// A subtree on the way from a wide node to its children.
struct WideSubtree {
  WideDecision decision;
  std::uint32_t left;  ///< slot of the left child; of no meaning for a leaf
};

/// The children of the wide node that `root`, which is no leaf, becomes; look_up(slot) finds a
/// WideSubtree.
template <class LookUp>
TREELET_HD inline WideChildren spread_over_children(const WideSubtree& root, LookUp&& look_up) {
  struct Item {
    std::uint32_t slot;
    int share;
  };
  Item stack[WideChoice::kWidth];  // their shares are disjoint parts of the width
  int waiting = 0;
  const auto push_sides = [&](const WideSubtree& subtree, int share) {
    const int left_share = subtree.decision.left_share(share);
    stack[waiting++] = {subtree.left + 1, share - left_share};
    stack[waiting++] = {subtree.left, left_share};
  };
  WideChildren children;
  push_sides(root, WideChoice::kWidth);
  while (waiting > 0) {
    const Item item = stack[--waiting];
    const WideSubtree subtree = look_up(item.slot);
    if (subtree.decision.stays_whole_in(item.share)) {
      children.slots[children.count++] = item.slot;
    } else {
      push_sides(subtree, item.share);
    }
  }
  return children;
}

}  // namespace treelet
