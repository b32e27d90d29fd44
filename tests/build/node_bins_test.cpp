#include <treelet/build/node_bins.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "support/random.h"
#include "support/splits.h"

namespace treelet {
namespace {

std::vector<BinaryNode> random_nodes(std::size_t count, std::uint64_t seed) {
  test::Random random(seed);
  std::vector<BinaryNode> nodes(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    const Vec3 lower = random.point(0.0f, 1.0f);
    nodes[i] = {lower, i, lower + random.point(0.0f, 0.1f), 1 + std::uint32_t(random.below(3))};
  }
  return nodes;
}

NodeGrid grid_over(const std::vector<BinaryNode>& nodes, int bins) {
  BoxLanes centroids = BoxLanes::empty();
  for (const BinaryNode& node : nodes)
    centroids.add_point(BoxLanes::load_box(node).doubled_centroid());
  return NodeGrid(centroids, bins);
}

auto goes_right(const NodeGrid& grid, int axis, int bin) {
  return [&grid, axis, bin](const BinaryNode& node) {
    return grid.of(BoxLanes::load_box(node))[axis] >= bin;
  };
}

test::SplitCost best_plane(const std::vector<BinaryNode>& nodes, const NodeGrid& grid) {
  test::SplitCost best;
  for (int axis = 0; axis < 3; ++axis) {
    for (int bin = 1; bin < grid.bins(); ++bin) {
      const auto cost = test::cost_of_split(nodes, goes_right(grid, axis, bin));
      if (cost.better_than(best)) best = cost;
    }
  }
  return best;
}

// The last count is binned in several chunks.
TEST(NodeBins, FindTheBestPlaneOfAll) {
  for (const std::size_t count : {2, 17, 300, 20'000}) {
    for (const int bins : {kMinNodeBins, 16, kMaxNodeBins}) {
      const auto nodes = random_nodes(count, 61);
      const NodeGrid grid = grid_over(nodes, bins);
      const NodeSplit found = find_node_split(nodes, grid);
      SCOPED_TRACE("seed 61, nodes " + std::to_string(count) + ", bins " + std::to_string(bins));
      const test::SplitCost best = best_plane(nodes, grid);
      ASSERT_TRUE(found.exists());
      EXPECT_NEAR(found.cost, best.cost, 1e-5 * best.cost);
      const auto cost = test::cost_of_split(nodes, goes_right(grid, found.axis, found.bin));
      EXPECT_NEAR(cost.cost, best.cost, 1e-5 * best.cost);
    }
  }
}

TEST(NodeBins, HaveBothEndsOfTheCentroids) {
  const auto nodes = random_nodes(1000, 62);
  const NodeGrid grid = grid_over(nodes, 32);
  for (int axis = 0; axis < 3; ++axis) {
    int least = 32, most = -1;
    for (const BinaryNode& node : nodes) {
      const int bin = grid.of(BoxLanes::load_box(node))[axis];
      least = std::min(least, bin);
      most = std::max(most, bin);
    }
    EXPECT_EQ(least, 0) << "seed 62";
    EXPECT_EQ(most, 31) << "seed 62";
  }
}

TEST(NodeBins, CannotPartEqualCentroids) {
  const std::vector<BinaryNode> nodes{{{0, 0, 0}, 0, {2, 2, 2}, 1}, {{1, 1, 1}, 1, {1, 1, 1}, 1}};
  EXPECT_FALSE(grid_over(nodes, 32).can_part());
}

TEST(NodeBins, CannotPartWhatIsTooNearForAFloat) {
  const float tiny = 1e-45f;
  const std::vector<BinaryNode> nodes{{{0, 0, 0}, 0, {0, 0, 0}, 1},
                                      {{tiny, 0, 0}, 1, {tiny, 0, 0}, 1}};
  EXPECT_FALSE(grid_over(nodes, 32).can_part());
}

}  // namespace
}  // namespace treelet
