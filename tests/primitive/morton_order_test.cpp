#include <treelet/primitive/morton_order.h>

#include <gtest/gtest.h>
#include <treelet/primitive/morton.h>

#include <vector>

#include "support/mesh_params.h"
#include "support/meshes.h"
#include "support/threads.h"

namespace treelet {
namespace {

class MortonOrderOfHardMeshes : public testing::TestWithParam<test::NamedMesh> {};
INSTANTIATE_TEST_SUITE_P(Meshes, MortonOrderOfHardMeshes, testing::ValuesIn(test::hard_meshes()),
                         test::mesh_name);

TEST_P(MortonOrderOfHardMeshes, HoldsEachReferenceOnceByCodeThenIndex) {
  const References references = create_references(GetParam().mesh.view());
  const MortonOrder order = sort_along_morton_curve(references);
  const MortonGrid grid = make_morton_grid(references.bounds);
  ASSERT_EQ(order.size(), references.size());
  ASSERT_EQ(order.references.size(), references.size());
  std::vector<bool> seen(references.size(), false);
  for (std::size_t i = 0; i < order.size(); ++i) {
    const std::uint32_t reference = order.references[i];
    ASSERT_LT(reference, references.size());
    ASSERT_FALSE(seen[reference]);
    seen[reference] = true;
    const Aabb box = references.items[reference].box();
    ASSERT_EQ(order.codes[i], morton_code(grid, doubled_centroid(box)));
    if (i == 0) continue;
    ASSERT_LE(order.codes[i - 1], order.codes[i]);
    if (order.codes[i - 1] == order.codes[i]) {
      ASSERT_LT(order.references[i - 1], reference);
    }
  }
}

TEST(MortonOrder, OfEqualCentresIsTheOrderOfReferences) {
  const test::OwnedMesh mesh = test::equal_centres(1000);
  const MortonOrder order = sort_along_morton_curve(create_references(mesh.view()));
  for (std::size_t i = 0; i < order.size(); ++i) {
    ASSERT_EQ(order.codes[i], order.codes[0]);
    ASSERT_EQ(order.references[i], i);
  }
}

TEST(MortonOrder, DoesNotDependOnThreads) {
  const test::OwnedMesh mesh = test::triangle_soup(40'000, 51);
  const test::ThreadCountScope one(1);
  const References references = create_references(mesh.view());
  const MortonOrder expected = sort_along_morton_curve(references);
  for (const unsigned threads : {2, 3, 5}) {
    const test::ThreadCountScope scope(threads);
    const MortonOrder order = sort_along_morton_curve(references);
    EXPECT_TRUE(std::equal(order.codes.begin(), order.codes.end(), expected.codes.begin()));
    EXPECT_TRUE(
        std::equal(order.references.begin(), order.references.end(), expected.references.begin()));
  }
}

}  // namespace
}  // namespace treelet
