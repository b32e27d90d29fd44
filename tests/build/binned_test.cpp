#include <treelet/build/binned.h>

#include <gtest/gtest.h>

#include <treelet/build/few_nodes.h>
#include <treelet/build/sweep.h>
#include <treelet/tree/refit.h>

#include <bit>
#include <stdexcept>

#include "support/mesh_params.h"
#include "support/meshes.h"
#include "support/threads.h"
#include "support/trees.h"

namespace treelet {
namespace {

class BinnedOfHardMeshes : public testing::TestWithParam<test::NamedMesh> {};
INSTANTIATE_TEST_SUITE_P(Meshes, BinnedOfHardMeshes, testing::ValuesIn(test::hard_meshes()),
                         test::mesh_name);

TEST_P(BinnedOfHardMeshes, IsSound) {
  const References references = create_references(GetParam().mesh.view());
  for (const int bins : {2, 32, 128}) {
    EXPECT_TRUE(test::IsSound(build_binned(references, {.bins = bins}), references)) << bins;
  }
}

TEST(Binned, IsTheSweepOfFewReferences) {
  for (std::uint64_t seed = 71; seed < 91; ++seed) {
    const References references = create_references(test::triangle_soup(kFewNodes, seed).view());
    EXPECT_EQ(sah_cost(build_binned(references), SahModel{}),
              sah_cost(build_sweep(references), SahModel{}))
        << "seed " << seed;
  }
}

TEST(Binned, IsNearlyTheSweep) {
  for (const test::OwnedMesh& mesh : {test::icosphere(5), test::triangle_soup(10'000, 72)}) {
    const References references = create_references(mesh.view());
    const double sweep = sah_cost(build_sweep(references), SahModel{});
    EXPECT_LT(sah_cost(build_binned(references), SahModel{}), 1.05 * sweep);
    EXPECT_LT(sah_cost(build_binned(references, {.bins = 128}), SahModel{}), 1.03 * sweep);
  }
}

TEST(Binned, HalvesIdenticalBoxes) {
  for (const std::size_t count : {2, 3, 50, 1000, 1024, 1025, 20'000}) {
    const References references = create_references(test::identical_triangles(count).view());
    EXPECT_EQ(test::depth(build_binned(references)), std::bit_width(count - 1)) << count;
  }
}

// Enough triangles for ranges that are binned and moved in several chunks.
TEST(Binned, DoesNotDependOnThreads) {
  const References references = create_references(test::triangle_soup(50'000, 74).view());
  const test::ThreadCountScope one(1);
  const BinaryTree expected = build_binned(references);
  ASSERT_TRUE(test::IsSound(expected, references));
  for (const unsigned threads : {2, 3, 5}) {
    const test::ThreadCountScope scope(threads);
    EXPECT_TRUE(test::equal_bytes(build_binned(references), expected)) << threads << " threads";
  }
}

TEST(Binned, RefusesBadBins) {
  EXPECT_THROW(build_binned({}, {.bins = 1}), std::invalid_argument);
  EXPECT_THROW(build_binned({}, {.bins = 129}), std::invalid_argument);
}

}  // namespace
}  // namespace treelet
