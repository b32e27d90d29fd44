#include <treelet/layout/wide_collapse.h>

#include <gtest/gtest.h>

#include <treelet/build/lbvh.h>
#include <treelet/layout/pack_cwbvh.h>
#include <treelet/layout/wide_collapse_lanes.h>
#include <treelet/layout/wide_collapse_steps.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <map>
#include <string>
#include <utility>

#include "support/isas.h"
#include "support/meshes.h"
#include "support/random.h"
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
    const std::uint32_t blocks = (node.count + model_.block_size - 1) / model_.block_size;
    return double(model_.block_cost) * half_area(node.box()) * blocks;
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
double cost_of_choices(const BinaryTree& tree, const WideCollapse& collapse, Oracle& oracle,
                       const WideCostModel& model, std::uint32_t slot) {
  if (collapse.is_leaf(slot)) return oracle.as_leaf(slot);
  double cost = double(model.node_cost) * half_area(tree.nodes[slot].box());
  for (const std::uint32_t child : list_wide_children(collapse, slot)) {
    cost += cost_of_choices(tree, collapse, oracle, model, child);
  }
  return cost;
}

TEST(WideCollapse, FindsTheLeastCostOnHardMeshes) {
  for (const auto& [name, mesh] : test::hard_meshes()) {
    const References references = create_references(mesh.view());
    if (references.size() == 0) continue;
    for (const WideCostModel& model :
         {WideCostModel{.leaf_limit = 1}, WideCostModel{.leaf_limit = 8},
          WideCostModel{.leaf_limit = 16}, CwbvhCostModel{}.checked()}) {
      for (const bool scrambled : {false, true}) {
        SCOPED_TRACE(name + ", leaf limit " + std::to_string(model.leaf_limit));
        const BinaryTree tree =
            scrambled ? test::random_tree(references, 3) : build_lbvh(references);
        const WideCollapse collapse = collapse_wide(tree, references, model);
        Oracle oracle(tree, model);
        const double best = oracle.cost(kRoot, 1);
        EXPECT_NEAR(double(collapse.root_cost), best, 1e-5 * best);
        EXPECT_NEAR(cost_of_choices(tree, collapse, oracle, model, kRoot), best, 1e-5 * best);
      }
    }
  }
}

/// Costs as a collapse could have found them: none falls as children are taken away; some are
/// equal.
WideChoice random_choice(test::Random& random) {
  WideChoice choice = choose_leaf(random.uniform(0.5f, 1.5f), {});
  for (int children = 2; children < WideChoice::kWidth; ++children) {
    const float before = choice.cost(children - 1);
    choice.set_cost(children, random.below(3) == 0 ? before : before * random.uniform(0.3f, 1.0f));
  }
  if (random.below(3) == 0) choice.set_cost(1, std::numeric_limits<float>::infinity());
  return choice;
}

WideCosts side_by_side(const WideChoice& choice) {
  WideCosts costs;
  costs.set_leaf(0.0f);
  std::copy_n(choice.costs, 7, costs.at_most);
  return costs;
}

TEST(WideCollapse, ChoosesSideBySideAsOneByOne) {
  const WideCostModel model;
  test::Random random(2026);
  for (int i = 0; i < 100'000; ++i) {
    const WideChoice left = random_choice(random), right = random_choice(random);
    const float half_area = random.uniform(0.1f, 4.0f);
    const std::uint32_t count = 2 + std::uint32_t(random.below(19));
    const WideChoice expected = choose_internal(half_area, count, left, right, {});
    for (const Isa isa : test::runnable_isas()) {
      WideCosts costs;
      const WideDecision decision =
          wide_chooser(isa)(wide_leaf_cost(half_area, count, model), model.node_cost * half_area,
                            side_by_side(left), side_by_side(right), costs);
      ASSERT_EQ(std::memcmp(&decision, &expected.decision, sizeof(decision)), 0);
      for (int children = 1; children < WideChoice::kWidth; ++children) {
        ASSERT_EQ(costs[children], expected.cost(children)) << children << " children";
      }
      ASSERT_EQ(costs[8], WideCosts::kInfinity);
    }
  }
}

TEST(WideCollapse, ChildrenAreAtMostEightAndPartitionTheSubtree) {
  const test::OwnedMesh mesh = test::triangle_soup(3000, 2);
  const References references = create_references(mesh.view());
  const BinaryTree tree = build_lbvh(references);
  const WideCollapse collapse = collapse_wide(tree, references, {});
  std::size_t full = 0, nodes = 0;
  std::vector<std::uint32_t> stack{kRoot};
  while (!stack.empty()) {
    const std::uint32_t slot = stack.back();
    stack.pop_back();
    const WideChildren children = list_wide_children(collapse, slot);
    ASSERT_GE(children.count, 2u);
    ASSERT_LE(children.count, 8u);
    ++nodes;
    full += children.count >= 6;
    std::uint32_t references_below = 0;
    for (const std::uint32_t child : children) {
      references_below += tree.nodes[child].count;
      if (!collapse.is_leaf(child)) stack.push_back(child);
    }
    ASSERT_EQ(references_below, tree.nodes[slot].count);
  }
  EXPECT_GT(full, nodes / 2);
}

TEST(WideCollapse, ARootThatWouldBeALeafIsItsOnlyChild) {
  const test::OwnedMesh mesh = test::one_triangle();
  const References references = create_references(mesh.view());
  const BinaryTree tree = build_lbvh(references);
  const WideChildren children = list_wide_children(collapse_wide(tree, references, {}), kRoot);
  ASSERT_EQ(children.count, 1u);
  EXPECT_EQ(children.slots[0], kRoot);
}

}  // namespace
}  // namespace treelet
