#pragma once

#include <cstdint>

#include <treelet/core/aabb.h>
#include <treelet/core/array.h>

namespace treelet {

/// A node and its subtree. Siblings lie next to each other, on one 64-byte line:
///
///     slot:   0      1      2 3    4 5    6 7   ...
///            root  unused   pair   pair   pair        pair p has slots p and p + 1, p even
///
/// An internal node names the pair of its children, so a subtree moves by copying its root node.
struct alignas(16) BinaryNode {
  Vec3 lower;
  std::uint32_t index;  ///< internal: slot of the left child; leaf: index of its reference
  Vec3 upper;
  std::uint32_t count;  ///< references in the subtree, 1 for a leaf

  TREELET_HD bool is_leaf() const { return count == 1; }
  TREELET_HD std::uint32_t left() const { return index; }
  TREELET_HD std::uint32_t right() const { return index + 1; }
  TREELET_HD Aabb box() const { return {lower, upper}; }
  TREELET_HD void set_box(const Aabb& box) {
    lower = box.lower;
    upper = box.upper;
  }
};
static_assert(sizeof(BinaryNode) == 32);

constexpr std::uint32_t kRoot = 0;

/// A full binary tree with one reference a leaf: what builders make, optimizers change and packers
/// read. n references take 2n slots; no references, no slots.
struct BinaryTree {
  Array<BinaryNode> nodes;

  BinaryTree() = default;
  explicit BinaryTree(std::size_t references) : nodes(2 * references) {
    if (references > 0) nodes[1] = {{0, 0, 0}, 0, {0, 0, 0}, 0};
  }

  std::size_t reference_count() const { return nodes.size() / 2; }
  bool empty() const { return nodes.empty(); }
};

}  // namespace treelet
