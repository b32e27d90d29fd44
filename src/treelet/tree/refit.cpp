#include <treelet/tree/refit.h>

#include <treelet/core/parallel.h>
#include <treelet/core/stage.h>
#include <treelet/tree/bottom_up.h>

namespace treelet {
namespace {

constexpr std::size_t kGrain = 1 << 14;

}  // namespace

void refit(BinaryTree& tree, const References& references) {
  const Stage stage{"refit boxes"};
  auto& nodes = tree.nodes;
  parallel_for(nodes.size(), kGrain, [&](std::size_t slot) {
    if (nodes[slot].is_leaf()) nodes[slot].set_box(references.items[nodes[slot].index].box());
  });
  visit_bottom_up(tree, kAllInternal, [&](std::uint32_t slot) {
    BinaryNode& node = nodes[slot];
    node.set_box(merge(nodes[node.left()].box(), nodes[node.right()].box()));
  });
}

Array<float> compute_costs(const BinaryTree& tree, const SahModel& sah) {
  const auto& nodes = tree.nodes;
  Array<float> costs(nodes.size());
  parallel_for(nodes.size(), kGrain, [&](std::size_t slot) {
    const BinaryNode& node = nodes[slot];
    costs[slot] = node.is_leaf() ? sah.leaf_cost(half_area(node.box()), 1) : 0.0f;
  });
  visit_bottom_up(tree, kAllInternal, [&](std::uint32_t slot) {
    const BinaryNode& node = nodes[slot];
    costs[slot] = sah.subtree_cost(half_area(node.box()), costs[node.left()] + costs[node.right()],
                                   node.count);
  });
  return costs;
}

double sah_cost(const BinaryTree& tree, const SahModel& sah) {
  if (tree.empty()) return 0.0;
  const auto area_of = [&](std::uint32_t slot) { return half_area(tree.nodes[slot].box()); };
  const double root_area = area_of(kRoot);
  if (!(root_area > 0.0)) return 0.0;
  const float cost = fold_bottom_up<float>(
      tree,
      [&](std::uint32_t slot, float& cost_of_leaf) {
        cost_of_leaf = sah.leaf_cost(area_of(slot), 1);
      },
      [&](std::uint32_t slot, float left, float right, float& cost_of_node) {
        cost_of_node = sah.subtree_cost(area_of(slot), left + right, tree.nodes[slot].count);
      });
  return cost / root_area;
}

}  // namespace treelet
