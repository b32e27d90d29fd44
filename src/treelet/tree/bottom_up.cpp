#include <treelet/tree/bottom_up.h>

namespace treelet {
namespace {

/// Pops nodes depth first and calls expand(slot), which says whether to go on to its children.
template <class Expand>
void walk_depth_first(const BinaryTree& tree, std::uint32_t root, Expand&& expand) {
  std::vector<std::uint32_t> stack{root};
  while (!stack.empty()) {
    const std::uint32_t slot = stack.back();
    stack.pop_back();
    if (!expand(slot)) continue;
    stack.push_back(tree.nodes[slot].right());
    stack.push_back(tree.nodes[slot].left());
  }
}

}  // namespace

TreeCut cut_tree(const BinaryTree& tree) {
  TreeCut cut;
  if (tree.empty()) return cut;
  walk_depth_first(tree, kRoot, [&](std::uint32_t slot) {
    const bool is_top = tree.nodes[slot].count > kSubtreeReferences;
    (is_top ? cut.top : cut.subtrees).push_back(slot);
    return is_top;
  });
  return cut;
}

void list_internal_nodes(const BinaryTree& tree, std::uint32_t root, std::uint32_t min_count,
                         std::vector<std::uint32_t>& nodes) {
  walk_depth_first(tree, root, [&](std::uint32_t slot) {
    const BinaryNode& node = tree.nodes[slot];
    if (node.is_leaf() || node.count < min_count) return false;
    nodes.push_back(slot);
    return true;
  });
}

}  // namespace treelet
