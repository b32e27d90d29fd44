#include <treelet/tree/bottom_up.h>

#include <algorithm>
#include <numeric>

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

LevelOrder order_by_level(const BinaryTree& tree, std::uint32_t min_count,
                          std::span<const std::uint32_t> nodes, Array<std::uint32_t>& levels) {
  const auto level_of_child = [&](std::uint32_t slot) {
    const BinaryNode& node = tree.nodes[slot];
    return node.is_leaf() || node.count < min_count ? 0 : levels[slot];
  };
  LevelOrder order;
  for (auto node = nodes.rbegin(); node != nodes.rend(); ++node) {
    const BinaryNode& parent = tree.nodes[*node];
    const std::uint32_t level =
        std::max(level_of_child(parent.left()), level_of_child(parent.right())) + 1;
    levels[*node] = level;
    if (order.ends.size() < level) order.ends.resize(level);
    ++order.ends[level - 1];
  }
  std::exclusive_scan(order.ends.begin(), order.ends.end(), order.ends.begin(), std::size_t{0});
  order.nodes.resize(nodes.size());
  for (const std::uint32_t slot : nodes) order.nodes[order.ends[levels[slot] - 1]++] = slot;
  return order;
}

}  // namespace treelet
