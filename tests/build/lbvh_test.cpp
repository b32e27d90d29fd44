#include <treelet/build/lbvh.h>

#include <gtest/gtest.h>
#include <treelet/primitive/morton_order.h>
#include <treelet/tree/refit.h>

#include <algorithm>
#include <bit>

#include "support/mesh_params.h"
#include "support/meshes.h"
#include "support/threads.h"
#include "support/trees.h"

namespace treelet {
namespace {

class LbvhOfHardMeshes : public testing::TestWithParam<test::NamedMesh> {};
INSTANTIATE_TEST_SUITE_P(Meshes, LbvhOfHardMeshes, testing::ValuesIn(test::hard_meshes()),
                         test::mesh_name);

TEST_P(LbvhOfHardMeshes, IsSound) {
  const References references = create_references(GetParam().mesh.view());
  EXPECT_TRUE(test::IsSound(build_lbvh(references), references));
}

TEST_P(LbvhOfHardMeshes, KeepsTheMortonOrder) {
  const References references = create_references(GetParam().mesh.view());
  if (references.size() == 0) return;
  const MortonOrder order = sort_along_morton_curve(references);
  const std::vector<std::uint32_t> expected(order.references.begin(), order.references.end());
  EXPECT_EQ(test::references_below(build_lbvh(references), kRoot), expected);
}

// Codes of 63 bits and the bits of an index.
TEST_P(LbvhOfHardMeshes, IsNoDeeperThanItsKeysAreLong) {
  const References references = create_references(GetParam().mesh.view());
  EXPECT_LE(test::depth(build_lbvh(references)), 63 + std::bit_width(references.size()));
}

TEST(Lbvh, OfEqualCodesIsFullAndBalanced) {
  for (std::size_t count = 1; count < 70; ++count) {
    const References references = create_references(test::equal_centres(count).view());
    const BinaryTree tree = build_lbvh(references);
    ASSERT_TRUE(test::IsSound(tree, references)) << count;
    ASSERT_EQ(test::depth(tree), std::bit_width(count - 1)) << count;
  }
}

TEST(Lbvh, SlowOfAMillionEqualCodesIsFullAndBalanced) {
  const References references = create_references(test::equal_centres(1'000'000).view());
  const BinaryTree tree = build_lbvh(references);
  EXPECT_TRUE(test::IsSound(tree, references));
  EXPECT_EQ(test::depth(tree), 20u);
}

TEST(Lbvh, DoesNotDependOnTheOrderOfTrianglesWhereCodesDiffer) {
  const test::OwnedMesh mesh = test::triangle_soup(3000, 111);
  const References references = create_references(mesh.view());
  const MortonOrder order = sort_along_morton_curve(references);
  ASSERT_EQ(std::adjacent_find(order.codes.begin(), order.codes.end()), order.codes.end());
  const double expected = sah_cost(build_lbvh(references), SahModel{});
  for (const std::uint64_t seed : {112, 113, 114}) {
    const References permuted = create_references(test::permuted(mesh, seed).view());
    EXPECT_EQ(sah_cost(build_lbvh(permuted), SahModel{}), expected) << "seed " << seed;
  }
}

TEST(Lbvh, DoesNotDependOnThreads) {
  const References references = create_references(test::triangle_soup(20'000, 115).view());
  const test::ThreadCountScope one(1);
  const BinaryTree expected = build_lbvh(references);
  ASSERT_TRUE(test::IsSound(expected, references));
  for (const unsigned threads : {2, 3, 5}) {
    const test::ThreadCountScope scope(threads);
    EXPECT_TRUE(test::equal_bytes(build_lbvh(references), expected)) << threads << " threads";
  }
}

}  // namespace
}  // namespace treelet
