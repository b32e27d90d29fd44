#include <treelet/layout/pack_bvh2.h>

#include <gtest/gtest.h>

#include <treelet/build/lbvh.h>
#include <treelet/layout/statistics.h>
#include <treelet/layout/validate_layout.h>
#include <treelet/optimize/treelet.h>
#include <treelet/tree/refit.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <set>
#include <string>
#include <vector>

#include "support/mesh_params.h"
#include "support/meshes.h"
#include "support/trees.h"

namespace treelet {
namespace {

using Sentences = std::vector<std::string>;

class PackHardMesh : public testing::TestWithParam<test::NamedMesh> {
 protected:
  const Mesh mesh_ = GetParam().mesh.view();
  const References references_ = create_references(mesh_);
};

TEST_P(PackHardMesh, IsSoundForEveryLeafLimit) {
  for (const std::uint32_t leaf_limit : {1u, 2u, 8u, 64u}) {
    const SahModel sah{.leaf_limit = leaf_limit};
    for (const bool scrambled : {false, true}) {
      SCOPED_TRACE("leaf limit " + std::to_string(leaf_limit) + ", scrambled " +
                   std::to_string(scrambled));
      const BinaryTree tree =
          scrambled ? test::random_tree(references_, 3) : build_lbvh(references_);
      const Bvh2 bvh = pack_bvh2(tree, references_, mesh_, sah);
      EXPECT_EQ(validate(bvh, mesh_), Sentences{});
      EXPECT_EQ(bvh.triangles.size(), references_.size());
      for (const Bvh2Node& node : bvh.nodes) {
        EXPECT_LE(std::max(node.count[0], node.count[1]), leaf_limit);
      }
    }
  }
}

TEST_P(PackHardMesh, KeepsTheCostOfTheTree) {
  const SahModel sah;
  BinaryTree tree = build_lbvh(references_);
  for (const bool optimized : {false, true}) {
    if (optimized) restructure_treelets(tree, sah, {});
    const Bvh2 bvh = pack_bvh2(tree, references_, mesh_, sah);
    const double in_build_space = sah_cost(tree, sah);
    EXPECT_NEAR(compute_statistics(bvh, sah).sah, in_build_space, 1e-5 * in_build_space);
  }
}

TEST_P(PackHardMesh, TrianglesAreTheMeshsBytes) {
  const Bvh2 bvh = pack_bvh2(build_lbvh(references_), references_, mesh_, {});
  std::set<std::uint32_t> faces;
  for (const PackedTriangle& packed : bvh.triangles) {
    const Triangle expected = mesh_.triangle(packed.face);
    EXPECT_EQ(std::memcmp(&packed.p0, &expected, sizeof expected), 0) << "face " << packed.face;
    faces.insert(packed.face);
  }
  EXPECT_EQ(faces.size(), bvh.triangles.size());
}

TEST_P(PackHardMesh, BoxesAreTight) {
  const Bvh2 bvh = pack_bvh2(build_lbvh(references_), references_, mesh_, {});
  Aabb all = Aabb::empty();
  for (const PackedTriangle& packed : bvh.triangles) all = merge(all, bounds(packed.triangle()));
  EXPECT_EQ(bvh.bounds, all);
  for (const Bvh2Node& node : bvh.nodes) {
    for (const int child : {0, 1}) {
      Aabb expected = Aabb::empty();
      if (node.is_leaf(child)) {
        for (std::uint32_t i = 0; i < node.count[child]; ++i) {
          expected = merge(expected, bounds(bvh.triangles[node.index[child] + i].triangle()));
        }
      } else if (!node.box[child].is_empty()) {
        const Bvh2Node& below = bvh.nodes[node.index[child]];
        expected = merge(below.box[0], below.box[1]);
      }
      EXPECT_EQ(node.box[child], expected);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Meshes, PackHardMesh, testing::ValuesIn(test::hard_meshes()),
                         test::mesh_name);

Bvh2 pack(const test::OwnedMesh& mesh, std::uint32_t leaf_limit) {
  const References references = create_references(mesh.view());
  return pack_bvh2(build_lbvh(references), references, mesh.view(), {.leaf_limit = leaf_limit});
}

TEST(PackBvh2, NothingHasNoNodes) {
  const Bvh2 bvh = pack(test::empty_mesh(), 8);
  EXPECT_TRUE(bvh.nodes.empty());
  EXPECT_TRUE(bvh.triangles.empty());
  EXPECT_TRUE(bvh.bounds.is_empty());
  EXPECT_EQ(bvh.depth, 0u);
}

TEST(PackBvh2, OneLeafIsTheFirstChildOfARoot) {
  const Bvh2 bvh = pack(test::two_triangles(), 2);
  ASSERT_EQ(bvh.nodes.size(), 1u);
  EXPECT_TRUE(bvh.is_single_leaf());
  EXPECT_EQ(bvh.nodes[0].count[0], 2u);
  EXPECT_EQ(bvh.nodes[0].count[1], 0u);
  EXPECT_EQ(bvh.bounds, (Aabb{{0, 0, 0}, {1, 1, 0}}));
  EXPECT_EQ(bvh.depth, 1u);
}

TEST(PackBvh2, TwoLeavesShareARoot) {
  const Bvh2 bvh = pack(test::two_triangles(), 1);
  ASSERT_EQ(bvh.nodes.size(), 1u);
  EXPECT_FALSE(bvh.is_single_leaf());
  EXPECT_EQ(bvh.nodes[0].index, (std::array<std::uint32_t, 2>{0, 1}));
  EXPECT_EQ(bvh.nodes[0].count, (std::array<std::uint32_t, 2>{1, 1}));
  EXPECT_EQ(bvh.depth, 1u);
}

TEST(PackBvh2, DepthIsThatOfAChain) {
  const test::OwnedMesh mesh = test::triangle_soup(100, 1);
  const References references = create_references(mesh.view());
  const Bvh2 bvh =
      pack_bvh2(test::chain_tree(references), references, mesh.view(), {.leaf_limit = 1});
  EXPECT_EQ(bvh.nodes.size(), 99u);
  EXPECT_EQ(bvh.depth, 99u);
  EXPECT_EQ(validate(bvh, mesh.view()), Sentences{});
}

TEST(PackBvh2, TreesAboveAndBelowTheCutAreSound) {
  // More references than one parallel subtree holds, in a tree with a deep, ragged top.
  const test::OwnedMesh mesh = test::triangle_soup(30000, 2);
  const References references = create_references(mesh.view());
  for (const bool chain : {false, true}) {
    const BinaryTree tree = chain ? test::chain_tree(references) : test::random_tree(references, 2);
    const Bvh2 bvh = pack_bvh2(tree, references, mesh.view(), {});
    EXPECT_EQ(validate(bvh, mesh.view()), Sentences{});
    const double cost = sah_cost(tree, {});
    const double tolerance = chain ? 1e-3 : 1e-5;  // 30000 floats after each other in a chain
    EXPECT_NEAR(compute_statistics(bvh, {}).sah, cost, tolerance * cost);
  }
}

TEST(PackBvh2, ARepeatedFaceIsStoredOnceALeaf) {
  const test::OwnedMesh mesh = test::triangle_soup(40, 3);
  const References whole = create_references(mesh.view());
  References references;
  references.may_repeat_faces = true;
  references.bounds = whole.bounds;
  references.items = Array<Reference>(80);
  for (std::size_t i = 0; i < 80; ++i) references.items[i] = whole.items[i / 2];
  const Bvh2 bvh = pack_bvh2(build_lbvh(references), references, mesh.view(), {});
  EXPECT_EQ(validate(bvh, mesh.view()), Sentences{});
  EXPECT_EQ(bvh.triangles.size(), 40u);  // both pieces have one box and so one leaf
}

}  // namespace
}  // namespace treelet
