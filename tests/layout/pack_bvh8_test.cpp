#include <treelet/layout/pack_bvh8.h>

#include <gtest/gtest.h>

#include <treelet/build/lbvh.h>
#include <treelet/layout/epo.h>
#include <treelet/layout/statistics.h>
#include <treelet/layout/validate_layout.h>

#include <string>
#include <vector>

#include "support/meshes.h"

namespace treelet {
namespace {

// What both wide packers promise is in pack_wide_test.cpp.

using Sentences = std::vector<std::string>;

Bvh8 pack(const test::OwnedMesh& mesh) {
  const References references = create_references(mesh.view());
  return pack_bvh8(build_lbvh(references), references, mesh.view(), WideCostModel{});
}

TEST(PackBvh8, OneTriangleIsALeafBelowTheRoot) {
  const Bvh8 bvh = pack(test::one_triangle());
  ASSERT_EQ(bvh.nodes.size(), 1u);
  ASSERT_EQ(bvh.blocks.size(), 1u);
  EXPECT_TRUE(bvh.nodes[0].child[0].is_leaf());
  EXPECT_TRUE(bvh.nodes[0].child[1].is_none());
  EXPECT_EQ(bvh.depth, 1u);
  for (const std::uint32_t lane : {1u, 2u, 3u}) {
    EXPECT_EQ(bvh.blocks[0].face[lane], TriangleBlock::kNoFace);
    EXPECT_EQ(bvh.blocks[0].triangle(lane), bvh.blocks[0].triangle(0));
  }
}

TEST(PackBvh8, TakesFewBytesATriangle) {
  const Bvh8 bvh = pack(test::icosphere(6));
  EXPECT_LT(double(bvh.bytes()) / double(bvh.triangle_count), 85.0);
}

TEST(ValidateBvh8, FindsWhatIsBroken) {
  const test::OwnedMesh mesh = test::triangle_soup(200, 1);
  const auto broken_by = [&](auto&& damage) {
    Bvh8 bvh = pack(mesh);
    damage(bvh);
    const Sentences sentences = validate(bvh, mesh.view());
    return sentences.empty() ? std::string() : sentences.front();
  };
  EXPECT_EQ(broken_by([](Bvh8&) {}), "");
  EXPECT_EQ(broken_by([](Bvh8& bvh) { bvh.nodes[0].planes[4][0] = -5.0f; }),
            "child 7 of node 1 sticks out of its parent's box");
  EXPECT_EQ(broken_by([](Bvh8& bvh) { bvh.bounds.upper.x = 0.0f; }).substr(0, 5), "child");
  EXPECT_EQ(broken_by([](Bvh8& bvh) { bvh.blocks[0].face[0] = 12345; }),
            "triangle 0 is of no face of the mesh");
  EXPECT_EQ(broken_by([](Bvh8& bvh) { bvh.depth = 0; }), "the tree is deeper than its depth says");
}

TEST(EpoOfBvh8, IsPositiveForOverlap) {
  EXPECT_GT(compute_epo(pack(test::triangle_soup(500, 3)), {}), 1.0);
}

}  // namespace
}  // namespace treelet
