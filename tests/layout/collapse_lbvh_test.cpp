#include <treelet/layout/collapse_lbvh.h>

#include <gtest/gtest.h>

#include <treelet/build/lbvh.h>
#include <treelet/tree/bottom_up.h>

#include <cstring>

#include "support/mesh_params.h"
#include "support/meshes.h"
#include "support/threads.h"

namespace treelet {
namespace {

void expect_the_long_way(const References& references, const WideCostModel& model) {
  const SahModel sah{.leaf_limit = model.leaf_limit};
  const WideCollapse expected = collapse_wide(build_lbvh(references), references, model, sah);
  const WideCollapse collapse = collapse_lbvh(references, model, sah);
  ASSERT_EQ(collapse.by_slot.size(), expected.by_slot.size());
  EXPECT_EQ(collapse.large, expected.large);
  EXPECT_EQ(collapse.root_cost, expected.root_cost);
  EXPECT_EQ(collapse.sah, expected.sah);
  for (std::size_t slot = 0; slot < expected.by_slot.size(); ++slot) {
    const CollapsedNode &node = collapse.by_slot[slot], &other = expected.by_slot[slot];
    ASSERT_EQ(std::memcmp(&node, &other, sizeof(node)), 0) << "slot " << slot;
  }
}

class CollapseLbvh : public testing::TestWithParam<test::NamedMesh> {};
INSTANTIATE_TEST_SUITE_P(Meshes, CollapseLbvh, testing::ValuesIn(test::hard_meshes()),
                         test::mesh_name);

TEST_P(CollapseLbvh, DecidesAsTheTreeWouldMakeIt) {
  const References references = create_references(GetParam().mesh.view());
  for (const std::uint32_t leaf_limit : {1u, 4u, 8u}) {
    expect_the_long_way(references, {.leaf_limit = leaf_limit});
  }
}

TEST(CollapseLbvh, OfManySubtreesOnAnyNumberOfThreads) {
  const test::OwnedMesh mesh = test::triangle_soup(60'000, 5);
  const References references = create_references(mesh.view());
  for (const unsigned threads : {1, 2, 5}) {
    const test::ThreadCountScope scope(threads);
    expect_the_long_way(references, {});
  }
}

TEST(CollapseLbvh, OfAMillionEqualCentresSlow) {
  const test::OwnedMesh mesh = test::equal_centres(1'000'000);
  expect_the_long_way(create_references(mesh.view()), {});
}

}  // namespace
}  // namespace treelet
