#include <treelet/optimize/treelet_levels.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <set>
#include <vector>

#include "support/random.h"
#include "support/trees.h"

namespace treelet {
namespace {

References random_references(std::size_t count, std::uint64_t seed) {
  test::Random random(seed);
  std::vector<Aabb> boxes;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 corner = random.point(0.0f, 1.0f);
    boxes.push_back({corner, corner + random.point(0.0f, 0.1f)});
  }
  return test::references_of(boxes);
}

void collect(const BinaryTree& tree, std::uint32_t slot, std::uint32_t min_count,
             std::multiset<std::uint32_t>& slots) {
  if (tree.nodes[slot].count < min_count) return;
  slots.insert(slot);
  collect(tree, tree.nodes[slot].left(), min_count, slots);
  collect(tree, tree.nodes[slot].right(), min_count, slots);
}

/// Lists what a recursive walk finds, and visits it children first.
void expect_levels(const BinaryTree& tree, const std::vector<std::uint32_t>& roots,
                   std::uint32_t min_count, TreeletLevels& levels) {
  std::multiset<std::uint32_t> expected;
  for (const std::uint32_t root : roots) collect(tree, root, min_count, expected);
  levels.list(tree, roots, min_count);
  std::multiset<std::uint32_t> visited;
  levels.visit_bottom_up([&](std::span<const std::uint32_t> level) {
    EXPECT_FALSE(level.empty());
    for (const std::uint32_t slot : level) {
      for (const std::uint32_t child : {tree.nodes[slot].left(), tree.nodes[slot].right()}) {
        EXPECT_EQ(visited.contains(child), tree.nodes[child].count >= min_count);
      }
    }
    visited.insert(level.begin(), level.end());
  });
  EXPECT_EQ(visited, expected);
}

TEST(TreeletLevels, ListAllNodesChildrenFirst) {
  TreeletLevels levels;  // used again
  for (const std::size_t count : {1u, 2u, 3u, 700u, 50u}) {
    const References references = random_references(count, count);
    for (const BinaryTree& tree : {test::random_tree(references, 3), test::chain_tree(references),
                                   test::balanced_tree(references)}) {
      for (const std::uint32_t min_count : {2u, 7u, 51u, 1000u}) {
        SCOPED_TRACE(std::to_string(count) + " references, min_count " + std::to_string(min_count));
        expect_levels(tree, {kRoot}, min_count, levels);
      }
    }
  }
}

TEST(TreeletLevels, MergeSubtreesByDepth) {
  const References references = random_references(600, 4);
  const BinaryTree tree = test::balanced_tree(references);
  const BinaryNode& root = tree.nodes[kRoot];
  const BinaryNode& left = tree.nodes[root.left()];
  TreeletLevels levels;
  expect_levels(tree, {left.left(), left.right(), root.right()}, 2, levels);
  expect_levels(tree, {}, 2, levels);

  levels.list(tree, std::vector{root.left(), root.right()}, 2);
  std::vector<std::size_t> sizes;
  levels.visit_bottom_up([&](auto level) { sizes.push_back(level.size()); });
  EXPECT_EQ(sizes.back(), 2u);  // both roots in one level
  EXPECT_EQ(sizes.size(), test::depth(tree) - 1);
}

}  // namespace
}  // namespace treelet
