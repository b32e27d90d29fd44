#include <treelet/build/grid_sah.h>

#include <gtest/gtest.h>

#include <treelet/build/binned.h>
#include <treelet/build/lbvh.h>
#include <treelet/tree/refit.h>

#include <bit>
#include <stdexcept>

#include "support/mesh_params.h"
#include "support/meshes.h"
#include "support/threads.h"
#include "support/trees.h"

namespace treelet {
namespace {

class GridSahOfHardMeshes : public testing::TestWithParam<test::NamedMesh> {};
INSTANTIATE_TEST_SUITE_P(Meshes, GridSahOfHardMeshes, testing::ValuesIn(test::hard_meshes()),
                         test::mesh_name);

TEST_P(GridSahOfHardMeshes, IsSound) {
  const References references = create_references(GetParam().mesh.view());
  for (const int bits : {kMinGridBits, 15, kMaxGridBits}) {
    EXPECT_TRUE(test::IsSound(build_grid_sah(references, {.bits = bits}), references)) << bits;
  }
}

TEST(GridSah, IsBinnedWhereThereAreFewReferences) {
  const References references = create_references(test::triangle_soup(64, 101).view());
  EXPECT_EQ(sah_cost(build_grid_sah(references), SahModel{}),
            sah_cost(build_binned(references), SahModel{}));
}

TEST(GridSah, LiesBetweenLbvhAndBinned) {
  for (const test::OwnedMesh& mesh : {test::icosphere(5), test::triangle_soup(10'000, 102)}) {
    const References references = create_references(mesh.view());
    const double cost = sah_cost(build_grid_sah(references), SahModel{});
    EXPECT_LT(cost, sah_cost(build_lbvh(references), SahModel{}));
    EXPECT_LT(cost, 1.15 * sah_cost(build_binned(references), SahModel{}));
  }
}

// Their codes are equal: no grid parts them.
TEST(GridSah, HalvesIdenticalBoxes) {
  for (const std::size_t count : {100, 1025}) {
    const References references = create_references(test::identical_triangles(count).view());
    EXPECT_EQ(test::depth(build_grid_sah(references)), std::bit_width(count - 1)) << count;
  }
}

TEST(GridSah, DoesNotDependOnThreads) {
  const References references = create_references(test::triangle_soup(20'000, 103).view());
  const test::ThreadCountScope one(1);
  const BinaryTree expected = build_grid_sah(references);
  for (const unsigned threads : {2, 5}) {
    const test::ThreadCountScope scope(threads);
    EXPECT_TRUE(test::equal_bytes(build_grid_sah(references), expected)) << threads << " threads";
  }
}

TEST(GridSah, RefusesBadParameters) {
  EXPECT_THROW(build_grid_sah({}, {.bits = 2}), std::invalid_argument);
  EXPECT_THROW(build_grid_sah({}, {.bits = 25}), std::invalid_argument);
  EXPECT_THROW(build_grid_sah({}, {.bins = 1}), std::invalid_argument);
}

}  // namespace
}  // namespace treelet
