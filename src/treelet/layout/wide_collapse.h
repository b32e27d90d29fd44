#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include <treelet/core/array.h>
#include <treelet/primitive/reference.h>
#include <treelet/tree/binary_tree.h>
#include <treelet/tree/sah.h>

namespace treelet {

/// What a wide layout pays, in visits of a node.
struct WideCostModel {
  float node_cost = 1.0f;
  float block_cost = 0.6f;       ///< of a block of triangles, full or not, measured against a node
  std::uint32_t leaf_limit = 8;  ///< triangles in a leaf at most
  std::uint32_t block_size = 4;  ///< triangles in a block
};

/// How a binary subtree is spread over the children of wide nodes, in one word.
struct WideDecision {
  std::uint32_t left_shares : 21;  ///< children that the left side gets of 2..8, three bits each
  std::uint32_t stays_whole : 8;   ///< bit i: with i children at hand, one is enough
  std::uint32_t is_leaf : 1;       ///< as one child: a leaf, else a node
  std::uint32_t is_node : 1;       ///< becomes a node of the layout; only the device asks
  std::uint32_t reserved : 1;      ///< zero

  /// What a single reference is: it never spreads.
  TREELET_HD static constexpr WideDecision leaf() { return {0, 0xff, 1, 0, 0}; }

  /// No internal node stays whole in no children.
  TREELET_HD constexpr bool is_reference() const { return stays_whole_in(0); }

  TREELET_HD constexpr int left_share(int children) const {
    return int(left_shares >> 3 * (children - 2) & 7);
  }
  TREELET_HD constexpr void set_left_share(int children, int share) {
    left_shares = (left_shares | unsigned(share) << 3 * (children - 2)) & 0x1fffff;
  }
  TREELET_HD constexpr bool stays_whole_in(int children) const {
    return (stays_whole >> children & 1) != 0;
  }
};
static_assert(sizeof(WideDecision) == 4);

/// A decision and what it costs.
struct WideChoice {
  static constexpr int kWidth = 8;

  WideDecision decision;
  float costs[kWidth - 1];

  /// Of the subtree in at most so many children.
  TREELET_HD constexpr float cost(int children) const { return costs[children - 1]; }
  TREELET_HD constexpr void set_cost(int children, float cost) { costs[children - 1] = cost; }
};
static_assert(sizeof(WideChoice) == 32);

/// A node of the binary tree, its box forgotten.
struct CollapsedNode {
  WideDecision decision;
  std::uint32_t index;  ///< slot of the left child; of a leaf of the binary tree, its reference
};

/// What has been decided about each node of a binary tree: all that a packer needs of the tree,
/// except for the boxes of pieces.
struct WideCollapse {
  Array<CollapsedNode> by_slot;
  std::vector<std::uint32_t> large{};  ///< slots with more than kSubtreeReferences, ascending
  float root_cost = 0.0f;
  double sah = 0.0;  ///< of the binary tree: collapsed_sah_cost (layout/leaf_collapse.h)
  /// By key, where slots tell the keys below them (layout/leaf_keys.h); else empty.
  Array<std::uint32_t> faces{};

  bool empty() const { return by_slot.empty(); }
  bool is_leaf(std::uint32_t slot) const { return by_slot[slot].decision.is_leaf != 0; }
  bool is_large(std::uint32_t slot) const {
    return std::binary_search(large.begin(), large.end(), slot);
  }
};

/// The cheapest way to make eight-wide nodes of a binary tree, leaves included, by dynamic
/// programming from the leaves up [YlitieKarrasLaine2017 s3.1]. Pieces of a face are one triangle
/// of a leaf. The walk also finds what the binary tree costs by another model.
WideCollapse collapse_wide(const BinaryTree& tree, const References& references,
                           const WideCostModel& model, const SahModel& sah = {});

/// The children of one wide node, left to right.
struct WideChildren {
  std::array<std::uint32_t, WideChoice::kWidth> slots;
  std::size_t count = 0;

  TREELET_HD const std::uint32_t* begin() const { return slots.data(); }
  TREELET_HD const std::uint32_t* end() const { return slots.data() + count; }
};

/// What becomes the children of the wide node at `slot`. Where a leaf would be cheaper than a node,
/// that leaf is the only child: a root has to be a node.
WideChildren list_wide_children(const WideCollapse& collapse, std::uint32_t slot);

}  // namespace treelet
