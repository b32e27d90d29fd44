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

std::vector<std::uint32_t> list_crown(const BinaryTree& tree) {
  std::vector<std::uint32_t> crown;
  if (tree.empty()) return crown;
  crown.push_back(kRoot);
  for (std::size_t i = 0; i < crown.size(); ++i) {
    const BinaryNode& node = tree.nodes[crown[i]];
    if (node.count <= kSubtreeReferences) continue;
    crown.push_back(node.left());
    crown.push_back(node.right());
  }
  return crown;
}

void list_internal_nodes(const BinaryTree& tree, std::uint32_t root, std::uint32_t min_count,
                         std::vector<std::uint32_t>& nodes) {
  std::size_t next = nodes.size(), end = next;
  nodes.resize(end + tree.nodes[root].count);  // one more than there can be
  // Without a branch on what no processor could predict: what is not wanted is written over.
  const auto add = [&](std::uint32_t slot) {
    const BinaryNode& node = tree.nodes[slot];
    const bool is_wanted = !node.is_leaf() && node.count >= min_count;
    TREELET_PREFETCH(is_wanted ? &tree.nodes[node.left()] : &node);
    nodes[end] = slot;
    end += is_wanted;
  };
  add(root);
  for (; next < end; ++next) {
    const BinaryNode& node = tree.nodes[nodes[next]];
    add(node.left());
    add(node.right());
  }
  nodes.resize(end);
}

}  // namespace treelet
