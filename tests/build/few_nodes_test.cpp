#include <treelet/build/few_nodes.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <vector>

#include <treelet/primitive/reference.h>

#include "support/random.h"
#include "support/splits.h"

namespace treelet {
namespace {

std::vector<BinaryNode> random_nodes(std::size_t count, test::Random& random) {
  std::vector<BinaryNode> nodes(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    const Vec3 lower = random.point(0.0f, 1.0f);
    nodes[i] = {lower, i, lower + random.point(0.0f, 0.3f), 1 + std::uint32_t(random.below(5))};
  }
  return nodes;
}

test::SplitCost best_of_all(const std::vector<BinaryNode>& nodes) {
  test::SplitCost best;
  for (int axis = 0; axis < 3; ++axis) {
    for (const BinaryNode& node : nodes) {
      const float limit = doubled_centroid(node.box())[axis];
      const auto cost = test::cost_of_split(nodes, [&](const BinaryNode& other) {
        return doubled_centroid(other.box())[axis] >= limit;
      });
      if (cost.better_than(best)) best = cost;
    }
  }
  return best;
}

TEST(SplitFewNodes, FindsTheBestSplitOfAll) {
  test::Random random(51);
  for (int trial = 0; trial < 500; ++trial) {
    const auto nodes = random_nodes(2 + random.below(kFewNodes - 1), random);
    const FewNodesSplit found = split_few_nodes(nodes);
    const test::SplitCost best = best_of_all(nodes);
    EXPECT_NEAR(found.split.cost, best.cost, 1e-5 * best.cost) << "seed 51, trial " << trial;
    const auto cost = test::cost_of_split(
        nodes, [&](const BinaryNode& node) { return (found.goes_right >> node.index & 1) != 0; });
    EXPECT_NEAR(cost.cost, best.cost, 1e-5 * best.cost) << "seed 51, trial " << trial;
    EXPECT_EQ(std::popcount(found.goes_right), int(nodes.size() - found.split.left_nodes));
  }
}

TEST(SplitFewNodes, HalvesIdenticalNodes) {
  for (std::size_t count = 2; count <= kFewNodes; ++count) {
    const std::vector<BinaryNode> nodes(count, {{0, 0, 0}, 0, {1, 1, 1}, 1});
    EXPECT_EQ(split_few_nodes(nodes).split.imbalance, (count + 1) / 2) << count;
  }
}

}  // namespace
}  // namespace treelet
