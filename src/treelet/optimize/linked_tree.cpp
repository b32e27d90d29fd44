#include <treelet/optimize/linked_tree.h>

#include <treelet/core/parallel.h>

namespace treelet {
namespace {

constexpr std::size_t kGrain = 1 << 14;

}  // namespace

LinkedTree::LinkedTree(BinaryTree& to_link) : tree(to_link), parents(to_link.reference_count()) {
  parallel_for(tree.nodes.size(), kGrain, [&](std::size_t slot) {
    const BinaryNode& node = tree.nodes[slot];
    if (node.count > 1) parents[node.left() / 2] = std::uint32_t(slot);
  });
}

void LinkedTree::remove(std::uint32_t slot) {
  const std::uint32_t above = parent(slot);
  place(BinaryNode(tree.nodes[sibling(slot)]), above);
  if (above != kRoot) fit_up_from(parent(above));
}

void LinkedTree::insert(const BinaryNode& node, std::uint32_t beside, std::uint32_t pair) {
  place(BinaryNode(tree.nodes[beside]), pair);
  place(node, pair + 1);
  tree.nodes[beside].index = pair;
  parents[pair / 2] = beside;
  fit_up_from(beside);
}

void LinkedTree::place(const BinaryNode& node, std::uint32_t slot) {
  tree.nodes[slot] = node;
  if (!node.is_leaf()) parents[node.left() / 2] = slot;
}

/// Takes boxes and counts from below, from a node up to the root.
void LinkedTree::fit_up_from(std::uint32_t slot) {
  for (;; slot = parent(slot)) {
    BinaryNode& node = tree.nodes[slot];
    const BinaryNode &left = tree.nodes[node.left()], &right = tree.nodes[node.right()];
    node.set_box(merge(left.box(), right.box()));
    node.count = left.count + right.count;
    if (slot == kRoot) return;
  }
}

}  // namespace treelet
