#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <treelet/core/array.h>
#include <treelet/primitive/reference.h>
#include <treelet/tree/binary_tree.h>

namespace treelet {

/// A subtree as a builder grows it from above that splits references on the way and so cannot know
/// how many leaves there will be: pairs of siblings in the order in which they were made, parents
/// before children.
class Branch {
 public:
  Branch() { add_pair(); }  // the root and an unused slot

  /// So many leaves and some more come.
  void reserve(std::size_t leaves) {
    nodes_.reserve(2 * leaves + leaves / 4);
    children_.reserve(2 * leaves + leaves / 4);
  }
  /// `leaf` has a box, a count of 1 and its face as index.
  void set_leaf(std::uint32_t slot, const BinaryNode& leaf) { nodes_[slot] = leaf; }
  /// Returns the slot of the left child; that of the right one comes next.
  std::uint32_t set_internal(std::uint32_t slot) {
    const std::uint32_t left = add_pair();
    children_[slot] = left;
    return left;
  }
  /// Makes boxes and counts, when all leaves are there.
  void sum_up();

  /// What join_branches does with a top, whose leaves have numbers of branches as indices, and with
  /// its branches.
  class Joiner;

 private:
  static constexpr std::uint32_t kLeaf = 0;  // the root is nobody's child

  std::uint32_t add_pair() {
    const std::uint32_t left = std::uint32_t(nodes_.size());
    nodes_.resize(left + 2);
    children_.resize(left + 2, kLeaf);
    return left;
  }
  bool is_leaf(std::size_t slot) const { return children_[slot] == kLeaf; }
  /// Calls visit(slot) for all nodes, parents first.
  template <class Visit>
  void for_each(Visit&& visit) const {
    for (std::size_t slot = 0; slot < nodes_.size(); ++slot) {
      if (slot != 1) visit(slot);
    }
  }
  void rank_leaves(std::uint32_t first);
  std::uint32_t final_slot(std::size_t slot) const {
    return 2 * first_leaves_[slot | 1] + std::uint32_t(slot & 1);
  }

  std::vector<BinaryNode> nodes_;
  std::vector<std::uint32_t> children_;      // by slot: that of the left child
  std::vector<std::uint32_t> first_leaves_;  // by slot: rank in the whole tree, from left to right
};

/// The tree of which `top` is the top, and in whose leaves the branches hang by their number. Takes
/// the references of the leaves, in the order of faces.
BinaryTree join_branches(Branch& top, std::span<Branch> branches, References& references);

}  // namespace treelet
