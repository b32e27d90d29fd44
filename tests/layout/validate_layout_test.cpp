#include <treelet/layout/validate_layout.h>

#include <gtest/gtest.h>

#include <treelet/layout/pack_bvh2.h>

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "support/meshes.h"
#include "support/trees.h"

namespace treelet {
namespace {

using Sentences = std::vector<std::string>;

/// Four triangles along x, in leaves of their own:
///
///     node 0 -+- node 1 -+- triangle 0
///             |          `- triangle 1
///             `- node 2 -+- triangle 2
///                        `- triangle 3
class ValidateLayout : public testing::Test {
 protected:
  void SetUp() override {
    for (int i = 0; i < 4; ++i) {
      const float x = 10.0f * float(i);
      owned_.add({x, 0, 0}, {x + 1, 0, 0}, {x, 1, 1});
    }
    const References references = create_references(owned_.view());
    const BinaryTree tree = test::balanced_tree(references, {0, 1, 2, 3});
    bvh_ = pack_bvh2(tree, references, owned_.view(), {.leaf_limit = 1});
    ASSERT_EQ(bvh_.nodes.size(), 3u);
    ASSERT_EQ(validate(), Sentences{});
    ASSERT_EQ(treelet::validate(bvh_), Sentences{});
  }

  Sentences validate() const { return treelet::validate(bvh_, owned_.view()); }

  /// What a broken way to node 2 costs besides.
  const Sentences all_triangles_lost_{"triangle 0 is in no leaf", "triangle 1 is in no leaf",
                                      "triangle 2 is in no leaf", "triangle 3 is in no leaf"};

  test::OwnedMesh owned_;
  Bvh2 bvh_;
};

Sentences operator+(Sentences a, const Sentences& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

TEST_F(ValidateLayout, SceneBoxTooSmall) {
  bvh_.bounds.upper.x = 30.5f;
  EXPECT_EQ(validate(), Sentences{"child 1 of node 0 sticks out of its parent's box"});
}

TEST_F(ValidateLayout, EachSideOfAnInternalBoxTooSmall) {
  const Bvh2 sound{bvh_.nodes.clone(), bvh_.triangles.clone(), bvh_.bounds, bvh_.depth};
  const auto broken_by = [&](const std::function<void(Aabb&)>& shrink) {
    bvh_.nodes = sound.nodes.clone();
    shrink(bvh_.nodes[0].box[0]);
    return validate();
  };
  const std::string first = "child 0 of node 1 sticks out of its parent's box";
  const std::string second = "child 1 of node 1 sticks out of its parent's box";
  EXPECT_EQ(broken_by([](Aabb& box) { box.lower.x = 0.5f; }), Sentences{first});
  EXPECT_EQ(broken_by([](Aabb& box) { box.upper.x = 10.5f; }), Sentences{second});
  EXPECT_EQ(broken_by([](Aabb& box) { box.lower.y = 0.5f; }), (Sentences{second, first}));
  EXPECT_EQ(broken_by([](Aabb& box) { box.upper.y = 0.5f; }), (Sentences{second, first}));
  EXPECT_EQ(broken_by([](Aabb& box) { box.lower.z = 0.5f; }), (Sentences{second, first}));
  EXPECT_EQ(broken_by([](Aabb& box) { box.upper.z = 0.5f; }), (Sentences{second, first}));
}

TEST_F(ValidateLayout, LeafBoxTooSmall) {
  bvh_.nodes[1].box[0].upper.z = 0.5f;
  EXPECT_EQ(validate(), Sentences{"child 0 of node 1 does not contain its triangle 0"});
}

TEST_F(ValidateLayout, NanInALeafBox) {
  bvh_.nodes[2].box[1].lower.y = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(validate(), (Sentences{"child 1 of node 2 sticks out of its parent's box",
                                   "child 1 of node 2 does not contain its triangle 3"}));
}

TEST_F(ValidateLayout, BoxTooLarge) {
  bvh_.nodes[0].box[0].lower.x = -1.0f;
  EXPECT_EQ(validate(), Sentences{"child 0 of node 0 sticks out of its parent's box"});
}

TEST_F(ValidateLayout, NodeIndexOfTheSibling) {
  bvh_.nodes[0].index[0] = 2;
  EXPECT_EQ(validate(),
            (Sentences{"node 2 is out of depth-first order", "1 nodes are unreachable"} +
             all_triangles_lost_));
}

TEST_F(ValidateLayout, NodeIndexThatDoesNotExist) {
  bvh_.nodes[0].index[1] = 3;
  EXPECT_EQ(validate(), (Sentences{"child 1 of node 0 does not exist", "1 nodes are unreachable",
                                   "triangle 2 is in no leaf", "triangle 3 is in no leaf"}));
}

TEST_F(ValidateLayout, InternalChildTakenForALeaf) {
  bvh_.nodes[0].count[1] = 1;
  EXPECT_EQ(validate(), (Sentences{"1 nodes are unreachable", "triangle 3 is in no leaf"}));
}

TEST_F(ValidateLayout, ACycle) {
  bvh_.nodes[1].count[0] = 0;
  bvh_.nodes[1].index[0] = 0;
  EXPECT_EQ(validate().front(), "node 0 is out of depth-first order");
}

TEST_F(ValidateLayout, TrianglesThatDoNotExist) {
  bvh_.nodes[2].count[1] = 2;
  EXPECT_EQ(validate(), (Sentences{"child 1 of node 2 has triangles that do not exist",
                                   "triangle 3 is in no leaf"}));
  bvh_.nodes[2].count[1] = 1;
  bvh_.nodes[2].index[1] = 0xffffffff;
  EXPECT_EQ(validate(), (Sentences{"child 1 of node 2 has triangles that do not exist",
                                   "triangle 3 is in no leaf"}));
}

TEST_F(ValidateLayout, ATriangleInTwoLeaves) {
  bvh_.nodes[2].index[1] = 2;
  EXPECT_EQ(validate(), (Sentences{"child 1 of node 2 does not contain its triangle 2",
                                   "triangle 2 is in two leaves", "triangle 3 is in no leaf"}));
}

TEST_F(ValidateLayout, DepthTooSmall) {
  bvh_.depth = 1;
  const std::string sentence = "the tree is deeper than its depth says";
  EXPECT_EQ(validate(), (Sentences{sentence, sentence}));
}

TEST_F(ValidateLayout, AVertexMovedOutOfItsBox) {
  bvh_.triangles[0].p1.x = 100.0f;
  EXPECT_EQ(validate(), (Sentences{"child 0 of node 1 does not contain its triangle 0",
                                   "triangle 0 differs from face 0"}));
}

TEST_F(ValidateLayout, AVertexMovedInsideItsBox) {
  for (Vec3 PackedTriangle::* vertex :
       {&PackedTriangle::p0, &PackedTriangle::p1, &PackedTriangle::p2}) {
    Vec3& moved = bvh_.triangles[1].*vertex;
    const Vec3 before = moved;
    moved = {10.5f, 0.5f, 0.5f};
    EXPECT_EQ(treelet::validate(bvh_), Sentences{});
    EXPECT_EQ(validate(), Sentences{"triangle 1 differs from face 1"});
    moved = before;
  }
}

TEST_F(ValidateLayout, ATriangleOfAnotherFace) {
  bvh_.triangles[0].face = 1;
  EXPECT_EQ(validate(), (Sentences{"triangle 0 differs from face 1", "face 0 is in no leaf"}));
  bvh_.triangles[0].face = 4;
  EXPECT_EQ(validate(),
            (Sentences{"triangle 0 is of no face of the mesh", "face 0 is in no leaf"}));
}

TEST_F(ValidateLayout, AFaceThatShouldHaveBeenLeftOut) {
  owned_.vertices[owned_.faces[2][1]] = owned_.vertices[owned_.faces[2][0]];
  EXPECT_EQ(validate(),
            (Sentences{"triangle 2 differs from face 2", "face 2 should have been left out"}));
}

TEST_F(ValidateLayout, AFaceTooMany) {
  owned_.add({5, 5, 5}, {6, 5, 5}, {5, 6, 5});
  EXPECT_EQ(validate(), Sentences{"face 4 is in no leaf"});
}

TEST(ValidateLayoutLimits, NothingOverNothingIsSound) {
  EXPECT_EQ(validate(Bvh2{}), Sentences{});
  EXPECT_EQ(validate(Bvh2{}, Mesh{}), Sentences{});
}

TEST(ValidateLayoutLimits, SaysAtMostTwentySentences) {
  const test::OwnedMesh mesh = test::triangle_soup(300, 1);
  const Sentences sentences = validate(Bvh2{}, mesh.view());
  ASSERT_EQ(sentences.size(), 20u);
  EXPECT_EQ(sentences.front(), "face 0 is in no leaf");
  EXPECT_EQ(sentences.back(), "face 19 is in no leaf");
}

}  // namespace
}  // namespace treelet
