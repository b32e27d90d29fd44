#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include <treelet/core/array.h>
#include <treelet/tree/binary_tree.h>

namespace treelet {

/// Where a tree over nodes goes.
struct JoinPlan {
  std::uint32_t root = kRoot;  ///< slot
  int bins = 32;               ///< of an axis
  /// Pairs that the tree may take: where its nodes are parted before the i-th one, the halves'
  /// roots go to slots first_slots[i] and the next. Empty: pair i.
  std::span<const std::uint32_t> first_slots{};
};

/// Gives a node its slot. Called by many threads at once.
using PlaceNode = std::function<void(const BinaryNode& node, std::uint32_t slot)>;

/// Builds a binary tree over at least one node, leaves or roots of subtrees, top down by binned SAH
/// [Wald2007]: a node weighs as much as it has references. Writes the internal nodes, boxes and
/// counts too, and calls `place` for those that were given.
void join_nodes(Array<BinaryNode> nodes, const JoinPlan& plan, const PlaceNode& place,
                BinaryTree& tree);

}  // namespace treelet
