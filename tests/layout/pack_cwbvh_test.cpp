#include <treelet/layout/pack_cwbvh.h>

#include <gtest/gtest.h>

#include <treelet/build/lbvh.h>
#include <treelet/layout/cwbvh_steps.h>
#include <treelet/layout/epo.h>
#include <treelet/layout/pack_bvh8.h>
#include <treelet/layout/statistics.h>
#include <treelet/layout/validate_layout.h>
#include <treelet/primitive/split.h>

#include <functional>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "support/layouts.h"
#include "support/meshes.h"
#include "support/threads.h"
#include "support/trees.h"

namespace treelet {
namespace {

using Sentences = std::vector<std::string>;

Cwbvh pack(const test::OwnedMesh& mesh, const CwbvhCostModel& model = {}) {
  const References references = create_references(mesh.view());
  return pack_cwbvh(build_lbvh(references), references, mesh.view(), model);
}

TEST(PackCwbvh, IsSoundOnEveryHardMesh) {
  for (const auto& [name, mesh] : test::hard_meshes()) {
    const References references = create_references(mesh.view());
    for (const std::uint32_t leaf_limit : {1u, 2u, 3u}) {
      for (const bool scrambled : {false, true}) {
        SCOPED_TRACE(name + ", leaf limit " + std::to_string(leaf_limit));
        const BinaryTree tree =
            scrambled ? test::random_tree(references, 3) : build_lbvh(references);
        const Cwbvh bvh = pack_cwbvh(tree, references, mesh.view(), {.leaf_limit = leaf_limit});
        EXPECT_EQ(validate(bvh, mesh.view()), Sentences{});
        EXPECT_EQ(bvh.triangles.size(), references.size());
        EXPECT_LE(compute_statistics(bvh, {}).leaf_histogram.size(), leaf_limit + 1);
      }
    }
  }
}

TEST(PackCwbvh, IsSoundOverSplitTriangles) {
  for (const auto& [name, mesh] : test::hard_meshes()) {
    SCOPED_TRACE(name);
    References references = create_references(mesh.view());
    split_references(references, mesh.view(), references.size());
    const Cwbvh bvh = pack_cwbvh(build_lbvh(references), references, mesh.view(), {});
    EXPECT_EQ(validate(bvh, mesh.view()), Sentences{});
  }
}

/// Exact boxes of the triangles below a node; each has to lie in the planes that its parent has.
Aabb expect_bounded(const Cwbvh& bvh, std::uint32_t index) {
  const CwbvhNode& node = bvh.nodes[index];
  Aabb whole = Aabb::empty();
  for (int i = 0; i < CwbvhNode::kChildren; ++i) {
    if (node.is_none(i)) continue;
    Aabb box = Aabb::empty();
    if (node.is_node(i)) {
      box = expect_bounded(bvh, node.node(i));
    } else {
      for (std::uint32_t k = 0; k < node.triangle_count(i); ++k) {
        box = merge(box, bounds(bvh.triangles[node.triangle(i) + k].triangle()));
      }
    }
    EXPECT_TRUE(decode_box(node, i).contains(box)) << "child " << i << " of node " << index;
    whole = merge(whole, box);
  }
  EXPECT_EQ(node.origin, whole.lower) << "node " << index;  // so the grid lies over the exact box
  return whole;
}

TEST(PackCwbvh, BoundsExactBoxesByPlanes) {
  for (const auto& [name, mesh] : test::hard_meshes()) {
    SCOPED_TRACE(name);
    const Cwbvh bvh = pack(mesh);
    if (bvh.nodes.empty()) continue;
    EXPECT_EQ(expect_bounded(bvh, 0), bvh.bounds);
  }
}

TEST(PackCwbvh, AnEmptyMeshHasNoNodes) {
  const Cwbvh bvh = pack(test::empty_mesh());
  EXPECT_TRUE(bvh.nodes.empty());
  EXPECT_TRUE(bvh.bounds.is_empty());
  EXPECT_EQ(bvh.bytes(), 0u);
}

TEST(PackCwbvh, OneTriangleIsALeafBelowTheRoot) {
  const Cwbvh bvh = pack(test::one_triangle());
  ASSERT_EQ(bvh.nodes.size(), 1u);
  ASSERT_EQ(bvh.triangles.size(), 1u);
  EXPECT_EQ(bvh.nodes[0].meta[0], CwbvhNode::leaf_meta(0, 1));
  EXPECT_EQ(bvh.nodes[0].node_mask, 0);
  EXPECT_EQ(bvh.depth, 1u);
  EXPECT_EQ(compute_statistics(bvh, {}).sah, 1.0);
}

TEST(PackCwbvh, KeepsEachFaceOnceInALeafThatHoldsItTwice) {
  const test::OwnedMesh mesh = test::two_triangles();
  References references = create_references(mesh.view());
  Array<Reference> repeated(4);
  for (std::size_t i = 0; i < 4; ++i) repeated[i] = references.items[i / 2];
  references.items = std::move(repeated);
  references.may_repeat_faces = true;
  const Cwbvh bvh = pack_cwbvh(build_lbvh(references), references, mesh.view(), {});
  ASSERT_EQ(bvh.triangles.size(), 2u);
  EXPECT_EQ((std::set{bvh.triangles[0].face, bvh.triangles[1].face}), (std::set{0u, 1u}));
}

TEST(PackCwbvh, GivesTheSameBytesForAnyNumberOfThreads) {
  const test::OwnedMesh mesh = test::triangle_soup(30000, 8);  // several parts below the cut
  const Cwbvh expected = pack(mesh);
  EXPECT_EQ(validate(expected, mesh.view()), Sentences{});
  for (const unsigned threads : {1u, 2u, 3u, 7u}) {
    const test::ThreadCountScope scope(threads);
    EXPECT_TRUE(test::equal_bytes(pack(mesh), expected));
  }
}

TEST(PackCwbvh, OfAChainIsSound) {
  const test::OwnedMesh mesh = test::triangle_soup(6000, 9);
  const References references = create_references(mesh.view());
  const Cwbvh bvh = pack_cwbvh(test::chain_tree(references), references, mesh.view(), {});
  EXPECT_EQ(validate(bvh, mesh.view()), Sentences{});
}

TEST(PackCwbvh, RefusesLeavesThatItsNodesCannotName) {
  for (const std::uint32_t leaf_limit : {0u, 4u}) {
    EXPECT_THROW(pack(test::one_triangle(), {.leaf_limit = leaf_limit}), std::invalid_argument);
  }
}

TEST(PackCwbvh, TakesFewBytesATriangle) {
  const Cwbvh bvh = pack(test::icosphere(6));
  EXPECT_LT(double(bvh.bytes()) / double(bvh.triangles.size()), 70.0);
}

/// Compression widens boxes by less than a cell on each side.
TEST(PackCwbvh, CostsLittleMoreThanExactBoxes) {
  const test::OwnedMesh mesh = test::icosphere(5);
  const References references = create_references(mesh.view());
  const BinaryTree tree = build_lbvh(references);
  const WideCostModel model = CwbvhCostModel{}.checked();
  const double exact = compute_statistics(pack_bvh8(tree, references, mesh.view(), model), {}).sah;
  const double compressed =
      compute_statistics(pack_cwbvh(tree, references, mesh.view(), {}), {}).sah;
  EXPECT_GT(compressed, exact);
  EXPECT_LT(compressed, 1.05 * exact);
}

TEST(ValidateCwbvh, FindsWhatIsBroken) {
  const test::OwnedMesh mesh = test::triangle_soup(200, 1);
  const auto broken_by = [&](const std::function<void(Cwbvh&)>& damage) {
    Cwbvh bvh = pack(mesh);
    damage(bvh);
    const Sentences sentences = validate(bvh, mesh.view());
    return sentences.empty() ? std::string() : sentences.front();
  };
  const auto leaf_of = [](const Cwbvh& bvh) {
    int i = 0;
    while (!bvh.nodes[bvh.nodes.size() - 1].is_leaf(i)) ++i;
    return i;
  };
  const auto last = [](Cwbvh& bvh) -> CwbvhNode& { return bvh.nodes[bvh.nodes.size() - 1]; };
  const auto has = [](const std::string& text, const char* part) {
    return text.find(part) != std::string::npos;
  };
  EXPECT_EQ(broken_by([](Cwbvh&) {}), "");
  EXPECT_TRUE(has(broken_by([&](Cwbvh& bvh) {
                    const int i = leaf_of(bvh);
                    last(bvh).upper[1][i] = last(bvh).lower[1][i];
                  }),
                  "does not contain its triangle"));
  EXPECT_TRUE(has(broken_by([](Cwbvh& bvh) { bvh.bounds.upper.x = 0.5f; }), "does not contain"));
  EXPECT_TRUE(has(broken_by([](Cwbvh& bvh) { --bvh.nodes[0].exponent[2]; }), "does not contain"));
  EXPECT_TRUE(has(broken_by([](Cwbvh& bvh) { ++bvh.nodes[0].first_node; }), "out of depth-first"));
  EXPECT_TRUE(has(broken_by([&](Cwbvh& bvh) { --last(bvh).first_triangle; }), "out of depth"));
  EXPECT_TRUE(has(broken_by([&](Cwbvh& bvh) { last(bvh).meta[leaf_of(bvh)] |= 31; }),
                  "neither a node nor a leaf"));
  EXPECT_TRUE(
      has(broken_by([&](Cwbvh& bvh) { last(bvh).meta[leaf_of(bvh)] = 0; }), "is in no leaf"));
  EXPECT_TRUE(has(broken_by([](Cwbvh& bvh) { bvh.nodes[0].node_mask ^= 1; }), "neither"));
  EXPECT_EQ(broken_by([](Cwbvh& bvh) { bvh.triangles[0].face = 12345; }),
            "triangle 0 is of no face of the mesh");
  EXPECT_EQ(broken_by([](Cwbvh& bvh) { bvh.depth = 0; }), "the tree is deeper than its depth says");
}

TEST(EpoOfCwbvh, IsZeroForSeparatedTrianglesAndNearThatOfExactBoxes) {
  test::OwnedMesh apart;
  for (int i = 0; i < 64; ++i) {
    const float x = float(3 * i);
    apart.add({x, 0, 0}, {x + 1, 0, 0}, {x, 1, 0});
  }
  EXPECT_EQ(compute_epo(pack(apart, {.leaf_limit = 1}), {}), 0.0);
  const test::OwnedMesh mesh = test::triangle_soup(500, 3);
  const References references = create_references(mesh.view());
  const BinaryTree tree = build_lbvh(references);
  const double compressed = compute_epo(pack_cwbvh(tree, references, mesh.view(), {}), {});
  const double exact =
      compute_epo(pack_bvh8(tree, references, mesh.view(), CwbvhCostModel{}.checked()), {});
  EXPECT_GT(compressed, exact);
  EXPECT_LT(compressed, 1.05 * exact);
}

}  // namespace
}  // namespace treelet
