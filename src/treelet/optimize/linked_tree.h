#pragma once

#include <cstdint>

#include <treelet/core/array.h>
#include <treelet/tree/binary_tree.h>

namespace treelet {

/// A tree and the slot of the node above each pair of slots, for optimizers that take subtrees out
/// and put them elsewhere.
struct LinkedTree {
  BinaryTree& tree;
  Array<std::uint32_t> parents;  ///< by pair; of no meaning for the root's

  explicit LinkedTree(BinaryTree& to_link);

  std::uint32_t parent(std::uint32_t slot) const { return parents[slot / 2]; }
  static std::uint32_t sibling(std::uint32_t slot) { return slot ^ 1; }
  const BinaryNode& operator[](std::uint32_t slot) const { return tree.nodes[slot]; }
  float area(std::uint32_t slot) const { return half_area(tree.nodes[slot].box()); }

  /// Takes a node other than the root out. The sibling takes its parent's slot, which leaves the
  /// node's pair free.
  void remove(std::uint32_t slot);
  /// Puts a node beside another one, under a new parent of both that takes the other's slot: into
  /// this pair, which nobody else uses.
  void insert(const BinaryNode& node, std::uint32_t beside, std::uint32_t pair);

 private:
  void place(const BinaryNode& node, std::uint32_t slot);
  void fit_up_from(std::uint32_t slot);
};

}  // namespace treelet
