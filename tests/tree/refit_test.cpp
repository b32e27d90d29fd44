#include <treelet/tree/refit.h>

#include <gtest/gtest.h>

#include <algorithm>

#include "support/mesh_params.h"
#include "support/meshes.h"
#include "support/threads.h"
#include "support/trees.h"

namespace treelet {
namespace {

/// Cost of a subtree by recursion, in double.
double cost_by_recursion(const BinaryTree& tree, std::uint32_t slot, const SahModel& sah) {
  const BinaryNode& node = tree.nodes[slot];
  const double area = half_area_double(node.box());
  const double leaf = area * double(sah.intersection_cost) * node.count;
  if (node.is_leaf()) return leaf;
  const double inner = double(sah.traversal_cost) * area +
                       cost_by_recursion(tree, node.left(), sah) +
                       cost_by_recursion(tree, node.right(), sah);
  return node.count <= sah.leaf_limit ? std::min(leaf, inner) : inner;
}

class RefitOfHardMeshes : public testing::TestWithParam<test::NamedMesh> {};
INSTANTIATE_TEST_SUITE_P(Meshes, RefitOfHardMeshes, testing::ValuesIn(test::hard_meshes()),
                         test::mesh_name);

TEST_P(RefitOfHardMeshes, RestoresAllBoxes) {
  const References references = create_references(GetParam().mesh.view());
  BinaryTree tree = test::random_tree(references, 91);
  for (BinaryNode& node : tree.nodes) node.set_box(Aabb::empty());
  refit(tree, references);
  EXPECT_TRUE(test::IsSound(tree, references));
  const Aabb root = tree.empty() ? Aabb::empty() : tree.nodes[kRoot].box();
  EXPECT_EQ(root, references.bounds);
}

TEST_P(RefitOfHardMeshes, CostsAreThoseOfTheRecursion) {
  const References references = create_references(GetParam().mesh.view());
  const BinaryTree tree = test::random_tree(references, 92);
  for (const SahModel& sah : {SahModel{}, SahModel{1.0f, 2.0f, 1}, SahModel{0.5f, 1.0f, 100}}) {
    const Array<float> costs = compute_costs(tree, sah);
    ASSERT_EQ(costs.size(), tree.nodes.size());
    for (std::uint32_t slot = 0; slot < tree.nodes.size(); ++slot) {
      if (slot == 1) continue;
      const double expected = cost_by_recursion(tree, slot, sah);
      ASSERT_NEAR(costs[slot], expected, 1e-5 * expected) << "slot " << slot;
    }
    if (tree.empty()) continue;
    const double area = half_area_double(tree.nodes[kRoot].box());
    const double expected = area > 0.0 ? cost_by_recursion(tree, kRoot, sah) / area : 0.0;
    EXPECT_NEAR(sah_cost(tree, sah), expected, 1e-5 * expected);
  }
}

double sah_of_identical(std::size_t count, const SahModel& sah) {
  const References references = create_references(test::identical_triangles(count).view());
  return sah_cost(test::balanced_tree(references), sah);
}

TEST(SahCost, OfIdenticalTrianglesCountsLeavesAndNodes) {
  const SahModel sah;
  EXPECT_NEAR(sah_of_identical(1, sah), 1.0, 1e-6);
  EXPECT_NEAR(sah_of_identical(8, sah), 8.0, 1e-6);                  // one leaf
  EXPECT_NEAR(sah_of_identical(16, sah), 16.0 + 1.2, 1e-5);          // two leaves of 8
  EXPECT_NEAR(sah_of_identical(16, {1.2f, 1, 4}), 16 + 3.6, 1e-5);   // four leaves of 4
  EXPECT_NEAR(sah_of_identical(4, {1.0f, 2.0f, 1}), 8.0 + 3, 1e-5);  // four leaves of 1
}

TEST(SahCost, OfSeparateBoxesIsTheSumOfTheirShares) {
  // Two unit cubes three apart: half areas of 3 within one of 1 * 1 + 2 * 4 = 9.
  References references;
  references.items = Array<Reference>(2);
  references.items[0] = {{0, 0, 0}, 0, {1, 1, 1}, 0};
  references.items[1] = {{3, 0, 0}, 1, {4, 1, 1}, 0};
  const BinaryTree tree = test::balanced_tree(references);
  EXPECT_NEAR(sah_cost(tree, SahModel{}), 1.2 + 2 * 3.0 / 9.0, 1e-6);
  EXPECT_NEAR(sah_cost(tree, SahModel{2.0f, 1.0f, 8}), 2.0, 1e-6);  // one leaf of 2
}

TEST(SahCost, OfNothingAndOfSegmentsIsZero) {
  EXPECT_EQ(sah_cost(BinaryTree(), SahModel{}), 0.0);
  test::OwnedMesh segments;
  for (int i = 0; i < 20; ++i) segments.add({0, 0, 0}, {1, 0, 0}, {float(2 + i), 0, 0});
  const References references = create_references(segments.view());
  EXPECT_EQ(sah_cost(test::balanced_tree(references), SahModel{}), 0.0);
}

TEST(ComputeCosts, DoNotDependOnThreads) {
  const References references = create_references(test::triangle_soup(20'000, 93).view());
  const test::ThreadCountScope one(1);
  BinaryTree tree = test::random_tree(references, 94);
  BinaryTree expected_tree;
  expected_tree.nodes = tree.nodes.clone();
  const Array<float> expected = compute_costs(tree, SahModel{});
  for (const unsigned threads : {2, 3, 5}) {
    const test::ThreadCountScope scope(threads);
    refit(tree, references);
    EXPECT_TRUE(test::equal_bytes(tree, expected_tree));
    const Array<float> costs = compute_costs(tree, SahModel{});
    EXPECT_TRUE(std::equal(costs.begin(), costs.end(), expected.begin()));
  }
}

}  // namespace
}  // namespace treelet
