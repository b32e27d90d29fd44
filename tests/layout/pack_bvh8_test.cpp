#include <treelet/layout/pack_bvh8.h>

#include <gtest/gtest.h>

#include <treelet/build/lbvh.h>
#include <treelet/layout/epo.h>
#include <treelet/layout/statistics.h>
#include <treelet/layout/validate_layout.h>

#include <cstring>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "support/meshes.h"
#include "support/threads.h"
#include "support/trees.h"

namespace treelet {
namespace {

using Sentences = std::vector<std::string>;

Bvh8 pack(const test::OwnedMesh& mesh, const WideCostModel& model = {}) {
  const References references = create_references(mesh.view());
  return pack_bvh8(build_lbvh(references), references, mesh.view(), model);
}

TEST(PackBvh8, IsSoundOnEveryHardMesh) {
  for (const auto& [name, mesh] : test::hard_meshes()) {
    const References references = create_references(mesh.view());
    for (const std::uint32_t leaf_limit : {1u, 2u, 8u, 16u}) {
      for (const bool scrambled : {false, true}) {
        SCOPED_TRACE(name + ", leaf limit " + std::to_string(leaf_limit));
        const BinaryTree tree =
            scrambled ? test::random_tree(references, 3) : build_lbvh(references);
        const Bvh8 bvh = pack_bvh8(tree, references, mesh.view(), {.leaf_limit = leaf_limit});
        EXPECT_EQ(validate(bvh, mesh.view()), Sentences{});
        EXPECT_EQ(bvh.triangle_count, references.size());
        EXPECT_LE(compute_statistics(bvh, {}).leaf_histogram.size(), leaf_limit + 1);
      }
    }
  }
}

TEST(PackBvh8, AnEmptyMeshHasNoNodes) {
  const Bvh8 bvh = pack(test::empty_mesh());
  EXPECT_TRUE(bvh.nodes.empty());
  EXPECT_TRUE(bvh.bounds.is_empty());
  EXPECT_EQ(bvh.bytes(), 0u);
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

TEST(PackBvh8, KeepsEachFaceOnceInALeafThatHoldsItTwice) {
  const test::OwnedMesh mesh = test::two_triangles();
  References references = create_references(mesh.view());
  Array<Reference> repeated(4);
  for (std::size_t i = 0; i < 4; ++i) repeated[i] = references.items[i / 2];
  references.items = std::move(repeated);
  references.may_repeat_faces = true;
  const Bvh8 bvh = pack_bvh8(build_lbvh(references), references, mesh.view(), {});
  std::multiset<std::uint32_t> faces;
  for (const std::uint32_t face : bvh.blocks[0].face) faces.insert(face);
  EXPECT_EQ(faces,
            (std::multiset<std::uint32_t>{0, 1, TriangleBlock::kNoFace, TriangleBlock::kNoFace}));
  EXPECT_EQ(bvh.triangle_count, 2u);
}

TEST(PackBvh8, GivesTheSameBytesForAnyNumberOfThreads) {
  const test::OwnedMesh mesh = test::triangle_soup(30000, 8);  // several parts below the cut
  const Bvh8 expected = pack(mesh);
  for (const unsigned threads : {1u, 2u, 3u, 7u}) {
    const test::ThreadCountScope scope(threads);
    const Bvh8 bvh = pack(mesh);
    ASSERT_EQ(bvh.nodes.size(), expected.nodes.size());
    ASSERT_EQ(bvh.blocks.size(), expected.blocks.size());
    EXPECT_EQ(std::memcmp(bvh.nodes.data(), expected.nodes.data(), bvh.nodes.bytes()), 0);
    EXPECT_EQ(std::memcmp(bvh.blocks.data(), expected.blocks.data(), bvh.blocks.bytes()), 0);
  }
}

TEST(PackBvh8, RefusesLeavesThatItsNodesCannotName) {
  for (const std::uint32_t leaf_limit : {0u, 17u}) {
    EXPECT_THROW(pack(test::one_triangle(), {.leaf_limit = leaf_limit}), std::invalid_argument);
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

TEST(EpoOfBvh8, IsZeroForSeparatedTrianglesAndPositiveForOverlap) {
  test::OwnedMesh apart;
  for (int i = 0; i < 64; ++i) {
    const float x = float(3 * i);
    apart.add({x, 0, 0}, {x + 1, 0, 0}, {x, 1, 0});
  }
  EXPECT_EQ(compute_epo(pack(apart, {.leaf_limit = 1}), {}), 0.0);
  EXPECT_GT(compute_epo(pack(test::triangle_soup(500, 3)), {}), 1.0);
}

}  // namespace
}  // namespace treelet
