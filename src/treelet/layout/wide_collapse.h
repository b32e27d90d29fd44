#pragma once

#include <array>
#include <cstdint>

#include <treelet/core/array.h>
#include <treelet/tree/binary_tree.h>

namespace treelet {

/// What a wide layout pays, in visits of a node.
struct WideCostModel {
  float node_cost = 1.0f;
  float block_cost = 0.6f;       ///< of a block of four triangles, measured against a node
  std::uint32_t leaf_limit = 8;  ///< triangles in a leaf at most
};

/// How a binary subtree is spread over the children of wide nodes.
struct WideChoice {
  static constexpr int kWidth = 8;

  std::array<float, kWidth>
      cost;  ///< cost[i]: of the subtree in at most i children; cost[0] unused
  std::array<std::uint8_t, kWidth + 1> left_share;  ///< children that the left side gets of i
  bool is_leaf;                                     ///< as one child: a leaf, else a node
  /// Bit i: with i children at hand, one is enough.
  std::uint8_t stays_whole;
};

/// The cheapest way to make eight-wide nodes of a binary tree, leaves included, by dynamic
/// programming from the leaves up [YlitieKarrasLaine2017 s3.1]. By slot.
Array<WideChoice> collapse_wide(const BinaryTree& tree, const WideCostModel& model);

/// The children of one wide node, left to right.
struct WideChildren {
  std::array<std::uint32_t, WideChoice::kWidth> slots;
  std::size_t count = 0;

  const std::uint32_t* begin() const { return slots.data(); }
  const std::uint32_t* end() const { return slots.data() + count; }
};

/// What becomes the children of the wide node at `slot`. Where a leaf would be cheaper than a node,
/// that leaf is the only child: a root has to be a node.
WideChildren list_wide_children(const BinaryTree& tree, const Array<WideChoice>& choices,
                                std::uint32_t slot);

}  // namespace treelet
