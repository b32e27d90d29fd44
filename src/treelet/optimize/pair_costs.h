#pragma once

#include <cstddef>
#include <cstdint>

#include <treelet/core/array.h>
#include <treelet/tree/binary_tree.h>
#include <treelet/tree/sah.h>

namespace treelet {

/// Costs of subtrees, by the pair of a node's children: half as many as by slot, and a cost stays
/// in place when its node moves. Leaves' costs are computed where they are read.
class PairCosts {
 public:
  PairCosts(const BinaryTree& tree, const SahModel& sah)
      : sah_(sah), costs_(tree.nodes.size() / 2) {}

  float of(const BinaryNode& node) const {
    return node.is_leaf() ? sah_.leaf_cost(half_area(node.box()), 1) : costs_[node.index / 2];
  }
  void set(std::uint32_t pair, float cost) { costs_[pair / 2] = cost; }
  /// Of an internal node, from its children's.
  float from_children(const BinaryTree& tree, std::uint32_t slot) const {
    const BinaryNode& node = tree.nodes[slot];
    const float children = of(tree.nodes[node.left()]) + of(tree.nodes[node.right()]);
    return sah_.subtree_cost(half_area(node.box()), children, node.count);
  }

  const SahModel& sah() const { return sah_; }
  float* data() { return costs_.data(); }

 private:
  const SahModel& sah_;
  Array<float> costs_;
};

}  // namespace treelet
