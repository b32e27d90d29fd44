#include <treelet/layout/check_structure.h>

#include <gtest/gtest.h>

#include <cmath>

#include <treelet/pipeline/build.h>

#include "support/meshes.h"
#include "support/recipes.h"

namespace treelet::test {
namespace {

std::string unsafe_part(const Bvh& bvh) {
  return std::visit([&](const auto& layout) { return find_unsafe_part(layout, bvh.report.faces); },
                    bvh.layout);
}

/// What is said of a tree after a change.
template <class Layout, class Change>
std::string after(const char* recipe, Change&& change) {
  Bvh bvh = build(triangle_soup(100, 3).view(), recipe);
  change(std::get<Layout>(bvh.layout));
  return unsafe_part(bvh);
}

TEST(CheckStructure, PassesEveryTreeThatIsBuilt) {
  for (const std::string& recipe : every_recipe()) {
    EXPECT_EQ(unsafe_part(build(soup_with_bad_faces(300, 5).view(), recipe)), "") << recipe;
  }
  for (const NamedMesh& mesh : hard_meshes()) {
    for (const char* recipe : {"lbvh > bvh2", "sbvh > bvh8", "lbvh > cwbvh"}) {
      EXPECT_EQ(unsafe_part(build(mesh.mesh.view(), recipe)), "") << mesh.name << ", " << recipe;
    }
  }
}

TEST(CheckStructure, NamesBrokenBinaryTrees) {
  const auto broken = [](auto&& change) { return after<Bvh2>("lbvh > bvh2", change); };
  const auto first_leaf = [](Bvh2& bvh) -> Bvh2Node& {
    return *std::find_if(bvh.nodes.begin(), bvh.nodes.end(),
                         [](const Bvh2Node& node) { return node.is_leaf(0); });
  };
  EXPECT_EQ(broken([](Bvh2& bvh) { bvh.nodes[0].index[0] = 0; }), "node 0 lacks a child");
  EXPECT_EQ(broken([](Bvh2& bvh) { bvh.nodes[0].index[1] = bvh.nodes[0].index[0]; }),
            "node 0 shares or leaves the arrays with child 1");
  EXPECT_EQ(broken([](Bvh2& bvh) { bvh.nodes[1].index[0] = 1; }),
            "node 1 shares or leaves the arrays with child 0");
  EXPECT_EQ(broken([](Bvh2& bvh) { bvh.nodes[0].index[1] = 100000; }),
            "node 0 shares or leaves the arrays with child 1");
  EXPECT_NE(broken([&](Bvh2& bvh) { first_leaf(bvh).index[0] = 0xffffffff; }), "");
  EXPECT_NE(broken([&](Bvh2& bvh) { first_leaf(bvh).count[0] += 1; }), "");
  EXPECT_NE(broken([&](Bvh2& bvh) { first_leaf(bvh).count[0] = 0xffffffff; }), "");
  EXPECT_EQ(broken([](Bvh2& bvh) { bvh.nodes[3].box[1].lower.z = std::nanf(""); }),
            "node 3 has no box around child 1");
  EXPECT_NE(broken([](Bvh2& bvh) { bvh.depth -= 1; }), "");
  EXPECT_NE(broken([](Bvh2& bvh) { bvh.depth += 1; }), "");
  EXPECT_EQ(broken([](Bvh2& bvh) { bvh.triangles[7].face = 100; }),
            "item 7 is of no face of the mesh");
  EXPECT_EQ(broken([](Bvh2& bvh) { bvh.triangles[8].p1.y = INFINITY; }),
            "item 8 has a vertex that is not finite");
  EXPECT_EQ(broken([](Bvh2& bvh) { bvh.bounds.upper.x = NAN; }), "the bounds are no box");
  EXPECT_EQ(broken([](Bvh2& bvh) { bvh.nodes = {}; }), "there are no nodes over the triangles");
}

TEST(CheckStructure, NamesBrokenWideTrees) {
  const auto broken = [](auto&& change) { return after<Bvh8>("lbvh > bvh8", change); };
  EXPECT_EQ(broken([](Bvh8& bvh) { bvh.nodes[0].child[0].bits = WideChild::kNone; }),
            "node 0 has no children");
  EXPECT_EQ(broken([](Bvh8& bvh) { bvh.nodes[0].child[1].bits = WideChild::kNone; }),
            "node 0 has a box without a child");
  EXPECT_EQ(broken([](Bvh8& bvh) {
              bvh.nodes[0].child[1].bits = WideChild::kNone;
              bvh.nodes[0].set_box(1, Aabb::empty());
            }),
            "node 0 has a child after a gap");
  EXPECT_EQ(broken([](Bvh8& bvh) { bvh.nodes[0].child[0] = WideChild::node(100000); }),
            "node 0 shares or leaves the arrays with child 0");
  EXPECT_EQ(broken([](Bvh8& bvh) { bvh.nodes[0].child[0] = WideChild::leaf(0x1fffffff, 4); }),
            "node 0 shares or leaves the arrays with child 0");
  EXPECT_EQ(broken([](Bvh8& bvh) { bvh.blocks[2].face[0] = TriangleBlock::kNoFace; }),
            "item 2 has a lane without a triangle before its last");
  EXPECT_EQ(broken([](Bvh8& bvh) { bvh.blocks[2].face[0] = 0x7fffffff; }),
            "item 2 has a triangle of no face of the mesh");
  EXPECT_NE(broken([](Bvh8& bvh) { bvh.triangle_count += 1; }), "");
}

TEST(CheckStructure, NamesBrokenCompressedTrees) {
  const auto broken = [](auto&& change) { return after<Cwbvh>("lbvh > cwbvh", change); };
  EXPECT_EQ(broken([](Cwbvh& bvh) { bvh.nodes[0].first_node = 0; }).find("node 0 shares"), 0u);
  EXPECT_EQ(broken([](Cwbvh& bvh) { bvh.nodes[0].first_node = 0xffffffff; }).find("node 0"), 0u);
  EXPECT_EQ(broken([](Cwbvh& bvh) { bvh.nodes[1].exponent[2] = 255; }),
            "node 1 has a grid without cells");
  EXPECT_EQ(broken([](Cwbvh& bvh) { bvh.nodes[1].origin.x = NAN; }),
            "node 1 has an origin that is not finite");
  EXPECT_NE(broken([](Cwbvh& bvh) { bvh.nodes[1].node_mask ^= 0xff; }), "");
  EXPECT_NE(broken([](Cwbvh& bvh) { bvh.nodes[1].first_triangle = 0xfffffff0; }), "");
  EXPECT_NE(broken([](Cwbvh& bvh) { bvh.nodes[1].meta[0] = 0x5f; }), "");
}

}  // namespace
}  // namespace treelet::test
