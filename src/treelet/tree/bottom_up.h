#pragma once

#include <span>
#include <vector>

#include <treelet/core/parallel.h>
#include <treelet/core/platform.h>
#include <treelet/tree/binary_tree.h>

namespace treelet {

/// The tree cut into a top and the subtrees below it, which threads can take one by one.
struct TreeCut {
  std::vector<std::uint32_t> top;       ///< internal nodes above the cut, parents first
  std::vector<std::uint32_t> subtrees;  ///< roots below the cut, from left to right
};

/// References of a subtree below the cut, at most. A constant, so that what a subtree is never
/// depends on the machine.
constexpr std::uint32_t kSubtreeReferences = 4096;

/// A min_count that all internal nodes have.
constexpr std::uint32_t kAllInternal = 2;

/// Reads only the counts.
TreeCut cut_tree(const BinaryTree& tree);

/// Nodes above the cut and the roots of the subtrees below it, breadth first: the children of the
/// k-th node above the cut are numbers 2k + 1 and 2k + 2.
std::vector<std::uint32_t> list_crown(const BinaryTree& tree);

/// Numbers of a crown that are one task.
constexpr std::size_t kCrownGrain = 4;

/// Internal nodes of the subtree at `root` with at least min_count references, breadth first: the
/// lines of a level are fetched while the one above is listed, where a walk in depth would wait for
/// each.
void list_internal_nodes(const BinaryTree& tree, std::uint32_t root, std::uint32_t min_count,
                         std::vector<std::uint32_t>& nodes);

/// What a subtree is worth, from the bottom up: leaf(slot, value) sets the value of a leaf, and may
/// be asked about other nodes in vain; join(slot, left, right, value) sets that of an internal
/// node, in its place: a copy would wait for what has just been stored in parts.
/// Values need no array by slot: breadth-first order, read backwards, meets children in the order
/// of their parents.
template <class T>
class SubtreeFold {
 public:
  template <class Leaf, class Join>
  T run(const BinaryTree& tree, std::uint32_t root, Leaf&& leaf, Join&& join) {
    nodes_.clear();
    list_internal_nodes(tree, root, kAllInternal, nodes_);
    values_.resize(nodes_.size() + 1);
    if (nodes_.empty()) leaf(root, values_[0]);
    const T* next = values_.data() + nodes_.size();
    for (std::size_t i = nodes_.size(); i-- > 0;) {
      const BinaryNode& node = tree.nodes[nodes_[i]];
      T leaves[2];
      leaf(node.left(), leaves[0]);
      leaf(node.right(), leaves[1]);
      const T* const right = tree.nodes[node.right()].is_leaf() ? &leaves[1] : --next;
      const T* const left = tree.nodes[node.left()].is_leaf() ? &leaves[0] : --next;
      join(nodes_[i], *left, *right, values_[i]);
    }
    return values_[0];
  }

 private:
  std::vector<std::uint32_t> nodes_;
  std::vector<T> values_;
};

/// The same of a whole tree, a subtree a task. The value of a tree without nodes is T().
template <class T, class Leaf, class Join>
T fold_bottom_up(const BinaryTree& tree, Leaf&& leaf, Join&& join) {
  if (tree.empty()) return T();
  const std::vector<std::uint32_t> crown = list_crown(tree);
  std::vector<T> values(crown.size());
  const auto is_top = [&](std::size_t i) {
    return tree.nodes[crown[i]].count > kSubtreeReferences;
  };
  parallel_for_ranges(crown.size(), kCrownGrain, [&](std::size_t begin, std::size_t end) {
    SubtreeFold<T> fold;
    for (std::size_t i = begin; i < end; ++i) {
      if (!is_top(i)) values[i] = fold.run(tree, crown[i], leaf, join);
    }
  });
  std::size_t next = crown.size();
  for (std::size_t i = crown.size(); i-- > 0;) {
    if (!is_top(i)) continue;
    next -= 2;
    join(crown[i], values[next], values[next + 1], values[i]);
  }
  return values[0];
}

/// Calls visit(slot) for each internal node of at least min_count references, after its children.
/// Nodes of different subtrees are visited at the same time. The visitor may rearrange the nodes
/// below its own slot: all that is still to be visited lies elsewhere or above.
/// Differs from [Karras2012 s4]: a subtree a task instead of a thread a leaf and atomic counters,
/// so that no parent links are needed.
template <class Visit>
void visit_bottom_up(const BinaryTree& tree, std::uint32_t min_count, Visit&& visit) {
  const TreeCut cut = cut_tree(tree);
  parallel_for_ranges(cut.subtrees.size(), 1, [&](std::size_t begin, std::size_t) {
    std::vector<std::uint32_t> nodes;
    list_internal_nodes(tree, cut.subtrees[begin], min_count, nodes);
    for (auto node = nodes.rbegin(); node != nodes.rend(); ++node) visit(*node);
  });
  for (auto node = cut.top.rbegin(); node != cut.top.rend(); ++node) {
    if (tree.nodes[*node].count >= min_count) visit(*node);
  }
}

}  // namespace treelet
