#include <treelet/build/hploc_steps.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "support/trees.h"

namespace treelet {
namespace {

constexpr Aabb kSmall{{0, 0, 0}, {1, 1, 1}}, kLarge{{0, 0, 0}, {1, 1, 2}};

TEST(MergeKey, PutsTheSmallerMergedBoxFirst) {
  EXPECT_LT(merge_key(kSmall, kSmall, 0, 31), merge_key(kSmall, kLarge, 0, 1));
  EXPECT_EQ(merge_key(kSmall, kLarge, 0, 1), merge_key(kLarge, kLarge, 0, 1));
  EXPECT_LT(merge_key(kLarge, kLarge, 0, 31), kNoMerge);
}

TEST(MergeKey, OfEqualBoxesPutsTheClosestGroupFirst) {
  const auto key = [](int i, int j) { return merge_key(kSmall, kSmall, i, j); };
  EXPECT_LT(key(2, 3), key(1, 2));
  EXPECT_LT(key(2, 3), key(3, 4));
  EXPECT_LT(key(0, 3), key(3, 4));
  EXPECT_EQ(key(2, 3), key(4, 5));
}

TEST(MergeKey, LeadsFromEachLaneToTheOther) {
  for (int i = 0; i < kHplocLanes; ++i) {
    for (int j = i + 1; j < kHplocLanes; ++j) {
      const std::uint64_t key = merge_key(kSmall, kLarge, i, j);
      ASSERT_EQ(lane_of_partner(i, key), j);
      ASSERT_EQ(lane_of_partner(j, key), i);
    }
  }
}

// So that some pair is first for both of its lanes.
TEST(MergeKey, DiffersBetweenPairsThatShareALane) {
  for (int i = 0; i < kHplocLanes; ++i) {
    std::set<std::uint64_t> keys;
    for (int j = 0; j < kHplocLanes; ++j) {
      if (j != i) keys.insert(merge_key(kSmall, kSmall, std::min(i, j), std::max(i, j)));
    }
    ASSERT_EQ(keys.size(), std::size_t(kHplocLanes - 1)) << "lane " << i;
  }
}

TEST(MergeKey, TakesMinusZeroForZero) {
  const Aabb flat{{0, 0, 0}, {1, 0, 0}}, minus_flat{{0, 0, 0}, {1, -0.0f, -0.0f}};
  EXPECT_EQ(merge_key(flat, flat, 0, 1), merge_key(minus_flat, minus_flat, 0, 1));
}

TEST(MergesClusters, AboveTheGoalAndAtTheRoot) {
  EXPECT_FALSE(merges_clusters(16, 17));
  EXPECT_TRUE(merges_clusters(17, 1000));
  EXPECT_TRUE(merges_clusters(2, 2));
}

TEST(MostClusters, IsTheGoalOrAllReferences) {
  EXPECT_EQ(most_clusters(1), 1);
  EXPECT_EQ(most_clusters(16), 16);
  EXPECT_EQ(most_clusters(std::int64_t{1} << 32), 16);
}

TEST(MergeClusters, WritesThePairOfTheUpperCluster) {
  const BinaryNode lower{{0, 0, 0}, 7, {1, 1, 1}, 1}, upper{{0, -1, 2}, 4, {1, 0, 3}, 3};
  BinaryTree tree(4);
  const BinaryNode merged = merge_clusters(lower, upper, 3, tree.nodes.data());
  EXPECT_EQ(tree.nodes[6].index, 7u);
  EXPECT_EQ(tree.nodes[6].count, 1u);
  EXPECT_EQ(tree.nodes[6].box(), lower.box());
  EXPECT_EQ(tree.nodes[7].index, 4u);
  EXPECT_EQ(tree.nodes[7].count, 3u);
  EXPECT_EQ(tree.nodes[7].box(), upper.box());
  EXPECT_EQ(merged.index, 6u);
  EXPECT_EQ(merged.count, 4u);
  EXPECT_EQ(merged.box(), (Aabb{{0, -1, 0}, {1, 1, 3}}));
}

}  // namespace
}  // namespace treelet
