#include <treelet/layout/statistics.h>

#include <gtest/gtest.h>

#include <vector>

namespace treelet {
namespace {

TEST(Statistics, OfNothing) {
  const TreeStatistics statistics = compute_statistics(Bvh2{}, {});
  EXPECT_EQ(statistics.nodes, 0u);
  EXPECT_EQ(statistics.leaves, 0u);
  EXPECT_EQ(statistics.triangles, 0u);
  EXPECT_EQ(statistics.bytes, 0u);
  EXPECT_EQ(statistics.sah, 0.0);
  EXPECT_TRUE(statistics.leaf_histogram.empty());
}

/// Two unit cubes side by side, a leaf of 3 and a node over leaves of 1 and 3.
Bvh2 two_nodes() {
  const Aabb left{{0, 0, 0}, {1, 1, 1}}, right{{1, 0, 0}, {2, 1, 1}}, half{{1, 0, 0}, {2, 1, 0}};
  Bvh2 bvh;
  bvh.bounds = merge(left, right);
  bvh.depth = 2;
  bvh.triangles = Array<PackedTriangle>(7);
  bvh.nodes = Array<Bvh2Node>(2);
  bvh.nodes[0] = {{left, right}, {0, 1}, {3, 0}};
  bvh.nodes[1] = {{half, right}, {3, 4}, {1, 3}};
  return bvh;
}

TEST(Statistics, CountsWhatIsThere) {
  const TreeStatistics statistics = compute_statistics(two_nodes(), {});
  EXPECT_EQ(statistics.nodes, 2u);
  EXPECT_EQ(statistics.leaves, 3u);
  EXPECT_EQ(statistics.triangles, 7u);
  EXPECT_EQ(statistics.bytes, 2u * 64 + 7u * 40);
  EXPECT_EQ(statistics.depth, 2u);
  EXPECT_EQ(statistics.leaf_histogram, (std::vector<std::size_t>{0, 1, 0, 2}));
}

TEST(Statistics, AddsTheCostOfEachNodeByHand) {
  // Half areas: root 5, cubes 3, square 1.
  const double expected = (1.2 * 5 + 3 * 3 + 1.2 * 3 + 1 * 1 + 3 * 3) / 5;
  EXPECT_NEAR(compute_statistics(two_nodes(), {}).sah, expected, 1e-6);
  const double dear = (2.0 * 5 + 4.0 * (3 * 3) + 2.0 * 3 + 4.0 * 1 + 4.0 * (3 * 3)) / 5;
  const SahModel sah{.traversal_cost = 2, .intersection_cost = 4};
  EXPECT_NEAR(compute_statistics(two_nodes(), sah).sah, dear, 1e-6);
}

TEST(Statistics, ASingleLeafCostsItsTriangles) {
  const Aabb box{{0, 0, 0}, {1, 2, 3}};
  Bvh2 bvh;
  bvh.bounds = box;
  bvh.triangles = Array<PackedTriangle>(5);
  bvh.nodes = Array<Bvh2Node>(1, {{box, Aabb::empty()}, {0, 0}, {5, 0}});
  EXPECT_EQ(compute_statistics(bvh, {}).sah, 5.0);
  EXPECT_EQ(compute_statistics(bvh, {}).leaves, 1u);
}

TEST(Statistics, APointCostsNothing) {
  const Aabb point{{1, 1, 1}, {1, 1, 1}};
  Bvh2 bvh;
  bvh.bounds = point;
  bvh.triangles = Array<PackedTriangle>(1);
  bvh.nodes = Array<Bvh2Node>(1, {{point, Aabb::empty()}, {0, 0}, {1, 0}});
  EXPECT_EQ(compute_statistics(bvh, {}).sah, 0.0);
}

}  // namespace
}  // namespace treelet
