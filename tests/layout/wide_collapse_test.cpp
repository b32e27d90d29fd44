#include <treelet/layout/wide_collapse.h>

#include <gtest/gtest.h>

#include <treelet/build/lbvh.h>

#include <algorithm>
#include <limits>
#include <map>
#include <string>
#include <utility>

#include "support/meshes.h"
#include "support/trees.h"

namespace treelet {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The least cost as its definition says it: a subtree in at most i children is a leaf, a node, or
/// its two sides with the children shared out in any way.
class Oracle {
 public:
  Oracle(const BinaryTree& tree, const WideCostModel& model) : tree_(tree), model_(model) {}

  double cost(std::uint32_t slot, int children) {
    const auto [found, is_new] = known_.try_emplace({slot, children}, 0.0);
    if (is_new) {
      double best = std::min(as_leaf(slot), as_node(slot));
      if (children > 1) best = std::min(best, shared_out(slot, children));
      known_[{slot, children}] = best;
    }
    return known_[{slot, children}];
  }

  double as_leaf(std::uint32_t slot) const {
    const BinaryNode& node = tree_.nodes[slot];
    if (node.count > model_.leaf_limit) return kInfinity;
    return double(model_.block_cost) * half_area(node.box()) * ((node.count + 3) / 4);
  }

  double as_node(std::uint32_t slot) {
    const BinaryNode& node = tree_.nodes[slot];
    if (node.is_leaf()) return kInfinity;
    return double(model_.node_cost) * half_area(node.box()) + shared_out(slot, 8);
  }

 private:
  double shared_out(std::uint32_t slot, int children) {
    const BinaryNode& node = tree_.nodes[slot];
    double best = kInfinity;
    for (int share = 1; share < children && !node.is_leaf(); ++share) {
      best = std::min(best, cost(node.left(), share) + cost(node.right(), children - share));
    }
    return best;
  }

  const BinaryTree& tree_;
  const WideCostModel& model_;
  std::map<std::pair<std::uint32_t, int>, double> known_;
};

/// What the chosen children cost, all the way down.
double cost_of_choices(const BinaryTree& tree, const Array<WideChoice>& choices, Oracle& oracle,
                       const WideCostModel& model, std::uint32_t slot) {
  if (choices[slot].decision.is_leaf) return oracle.as_leaf(slot);
  double cost = double(model.node_cost) * half_area(tree.nodes[slot].box());
  for (const std::uint32_t child : list_wide_children(tree, choices, slot)) {
    cost += cost_of_choices(tree, choices, oracle, model, child);
  }
  return cost;
}

TEST(WideCollapse, FindsTheLeastCostOnHardMeshes) {
  for (const auto& [name, mesh] : test::hard_meshes()) {
    const References references = create_references(mesh.view());
    if (references.size() == 0) continue;
    for (const std::uint32_t leaf_limit : {1u, 8u, 16u}) {
      for (const bool scrambled : {false, true}) {
        SCOPED_TRACE(name + ", leaf limit " + std::to_string(leaf_limit));
        const WideCostModel model{.leaf_limit = leaf_limit};
        const BinaryTree tree =
            scrambled ? test::random_tree(references, 3) : build_lbvh(references);
        const Array<WideChoice> choices = collapse_wide(tree, references, model);
        Oracle oracle(tree, model);
        const double best = oracle.cost(kRoot, 1);
        EXPECT_NEAR(double(choices[kRoot].cost(1)), best, 1e-5 * best);
        EXPECT_NEAR(cost_of_choices(tree, choices, oracle, model, kRoot), best, 1e-5 * best);
      }
    }
  }
}

TEST(WideCollapse, ChildrenAreAtMostEightAndPartitionTheSubtree) {
  const test::OwnedMesh mesh = test::triangle_soup(3000, 2);
  const References references = create_references(mesh.view());
  const BinaryTree tree = build_lbvh(references);
  const Array<WideChoice> choices = collapse_wide(tree, references, {});
  std::size_t full = 0, nodes = 0;
  std::vector<std::uint32_t> stack{kRoot};
  while (!stack.empty()) {
    const std::uint32_t slot = stack.back();
    stack.pop_back();
    const WideChildren children = list_wide_children(tree, choices, slot);
    ASSERT_GE(children.count, 2u);
    ASSERT_LE(children.count, 8u);
    ++nodes;
    full += children.count >= 6;
    std::uint32_t references_below = 0;
    for (const std::uint32_t child : children) {
      references_below += tree.nodes[child].count;
      if (!choices[child].decision.is_leaf) stack.push_back(child);
    }
    ASSERT_EQ(references_below, tree.nodes[slot].count);
  }
  EXPECT_GT(full, nodes / 2);
}

TEST(WideCollapse, ARootThatWouldBeALeafIsItsOnlyChild) {
  const test::OwnedMesh mesh = test::one_triangle();
  const References references = create_references(mesh.view());
  const BinaryTree tree = build_lbvh(references);
  const WideChildren children =
      list_wide_children(tree, collapse_wide(tree, references, {}), kRoot);
  ASSERT_EQ(children.count, 1u);
  EXPECT_EQ(children.slots[0], kRoot);
}

}  // namespace
}  // namespace treelet
