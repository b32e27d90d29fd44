#pragma once

#include <algorithm>
#include <utility>

#include <treelet/core/array.h>
#include <treelet/tree/binary_tree.h>
#include <treelet/tree/refit.h>
#include <treelet/tree/sah.h>

namespace treelet {

/// Remembers the cheapest of the trees that an optimizer passes through, leaves of the layout
/// counted.
class BestTree {
 public:
  BestTree(const BinaryTree& tree, const SahModel& sah)
      : sah_(sah), cost_(sah_cost(tree, sah)), nodes_(tree.nodes.clone()) {}

  /// Whether the tree is cheaper than all before.
  bool offer(const BinaryTree& tree) {
    const double cost = sah_cost(tree, sah_);
    is_last_ = cost < cost_;
    if (!is_last_) return false;
    cost_ = cost;
    std::copy(tree.nodes.begin(), tree.nodes.end(), nodes_.begin());
    return true;
  }

  void restore(BinaryTree& tree) {
    if (!is_last_) tree.nodes = std::move(nodes_);
  }

 private:
  const SahModel& sah_;
  double cost_;
  bool is_last_ = true;  ///< the tree offered last is the best
  Array<BinaryNode> nodes_;
};

}  // namespace treelet
