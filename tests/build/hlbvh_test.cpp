#include <treelet/build/hlbvh.h>

#include <gtest/gtest.h>

#include <treelet/build/binned.h>
#include <treelet/build/lbvh.h>
#include <treelet/primitive/morton.h>
#include <treelet/tree/refit.h>

#include <algorithm>
#include <set>
#include <stdexcept>
#include <vector>

#include "support/mesh_params.h"
#include "support/meshes.h"
#include "support/threads.h"
#include "support/trees.h"

namespace treelet {
namespace {

using References32 = std::vector<std::uint32_t>;

/// The sets of references below each node.
std::set<References32> clusters_of(const BinaryTree& tree) {
  std::set<References32> clusters;
  for (std::uint32_t slot = 0; slot < tree.nodes.size(); ++slot) {
    if (slot == 1) continue;
    References32 below = test::references_below(tree, slot);
    std::sort(below.begin(), below.end());
    clusters.insert(std::move(below));
  }
  return clusters;
}

bool lies_in_one_cell(const References32& below, const References& references, int bits) {
  const MortonGrid grid = make_morton_grid(references.bounds);
  std::set<std::uint64_t> cells;
  for (const std::uint32_t i : below) {
    const Vec3 centroid = doubled_centroid(references.items[i].box());
    cells.insert(morton_code(grid, centroid) >> (kMortonBits - bits));
  }
  return cells.size() == 1;
}

class HlbvhOfHardMeshes : public testing::TestWithParam<test::NamedMesh> {};
INSTANTIATE_TEST_SUITE_P(Meshes, HlbvhOfHardMeshes, testing::ValuesIn(test::hard_meshes()),
                         test::mesh_name);

TEST_P(HlbvhOfHardMeshes, IsSound) {
  const References references = create_references(GetParam().mesh.view());
  for (const int bits : {0, 6, 15, kMaxHlbvhBits}) {
    EXPECT_TRUE(test::IsSound(build_hlbvh(references, {.bits = bits}), references)) << bits;
  }
}

TEST(Hlbvh, KeepsTheLbvhInsideOfCells) {
  const References references = create_references(test::triangle_soup(2000, 91).view());
  const auto in_tree = clusters_of(build_hlbvh(references, {.bits = 6}));
  std::size_t kept = 0;
  for (const References32& below : clusters_of(build_lbvh(references))) {
    if (!lies_in_one_cell(below, references, 6)) continue;
    ++kept;
    EXPECT_TRUE(in_tree.contains(below));
  }
  EXPECT_GT(kept, 3000u);
}

TEST(Hlbvh, IsTheLbvhWhereAllIsOneCell) {
  const References references = create_references(test::triangle_soup(1000, 92).view());
  EXPECT_TRUE(test::equal_bytes(build_hlbvh(references, {.bits = 0}), build_lbvh(references)));
}

TEST(Hlbvh, IsBinnedWhereEachReferenceHasACell) {
  const References references = create_references(test::triangle_soup(300, 93).view());
  EXPECT_EQ(sah_cost(build_hlbvh(references, {.bits = kMaxHlbvhBits}), SahModel{}),
            sah_cost(build_binned(references), SahModel{}));
}

TEST(Hlbvh, IsBetterThanLbvh) {
  for (const test::OwnedMesh& mesh : {test::icosphere(5), test::triangle_soup(10'000, 94)}) {
    const References references = create_references(mesh.view());
    EXPECT_LT(sah_cost(build_hlbvh(references), SahModel{}),
              sah_cost(build_lbvh(references), SahModel{}));
  }
}

TEST(Hlbvh, DoesNotDependOnThreads) {
  const References references = create_references(test::triangle_soup(20'000, 95).view());
  const test::ThreadCountScope one(1);
  const BinaryTree expected = build_hlbvh(references);
  for (const unsigned threads : {2, 5}) {
    const test::ThreadCountScope scope(threads);
    EXPECT_TRUE(test::equal_bytes(build_hlbvh(references), expected)) << threads << " threads";
  }
}

TEST(Hlbvh, RefusesBadParameters) {
  EXPECT_THROW(build_hlbvh({}, {.bits = -1}), std::invalid_argument);
  EXPECT_THROW(build_hlbvh({}, {.bits = 31}), std::invalid_argument);
  EXPECT_THROW(build_hlbvh({}, {.bins = 1}), std::invalid_argument);
}

}  // namespace
}  // namespace treelet
