#include <treelet/layout/pack_cwbvh.h>

#include <gtest/gtest.h>

#include <treelet/build/lbvh.h>
#include <treelet/layout/cwbvh_steps.h>
#include <treelet/layout/epo.h>
#include <treelet/layout/pack_bvh8.h>
#include <treelet/layout/statistics.h>
#include <treelet/layout/validate_layout.h>

#include <functional>
#include <string>
#include <vector>

#include "support/meshes.h"

namespace treelet {
namespace {

// What both wide packers promise is in pack_wide_test.cpp.

using Sentences = std::vector<std::string>;

Cwbvh pack(const test::OwnedMesh& mesh) {
  const References references = create_references(mesh.view());
  return pack_cwbvh(build_lbvh(references), references, mesh.view(), {});
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

TEST(PackCwbvh, OneTriangleIsALeafBelowTheRoot) {
  const Cwbvh bvh = pack(test::one_triangle());
  ASSERT_EQ(bvh.nodes.size(), 1u);
  ASSERT_EQ(bvh.triangles.size(), 1u);
  EXPECT_EQ(bvh.nodes[0].meta[0], CwbvhNode::leaf_meta(0, 1));
  EXPECT_EQ(bvh.nodes[0].node_mask, 0);
  EXPECT_EQ(bvh.depth, 1u);
  EXPECT_EQ(compute_statistics(bvh, {}).sah, 1.0);
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

TEST(EpoOfCwbvh, IsNearThatOfExactBoxes) {
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
