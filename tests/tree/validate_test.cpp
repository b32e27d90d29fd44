#include <treelet/tree/validate.h>

#include <gtest/gtest.h>

#include <cmath>

#include "support/meshes.h"
#include "support/trees.h"

namespace treelet {
namespace {

using Sentences = std::vector<std::string>;

//               0
//          2         3
//        4   5     6   7        slots
//       r0   r1   r2   r3       references
class ValidateTreeOfFour : public testing::Test {
 protected:
  ValidateTreeOfFour()
      : references(create_references(test::triangle_soup(4, 71).view())),
        tree(test::balanced_tree(references)) {}

  BinaryNode& node(std::uint32_t slot) { return tree.nodes[slot]; }
  Sentences violations() const { return validate(tree, references); }

  References references;
  BinaryTree tree;
};

TEST_F(ValidateTreeOfFour, FindsNothingInASoundTree) {
  ASSERT_EQ(node(0).index, 2u);
  ASSERT_EQ(node(2).index, 4u);
  ASSERT_EQ(node(3).index, 6u);
  EXPECT_EQ(violations(), Sentences{});
}

TEST_F(ValidateTreeOfFour, FindsALeafWithoutReference) {
  node(4).index = 4;
  EXPECT_EQ(violations(), (Sentences{"node 4 holds reference 4, which does not exist",
                                     "reference 0 is in no leaf"}));
}

TEST_F(ValidateTreeOfFour, FindsAReferenceInTwoLeaves) {
  node(5).index = 0;
  EXPECT_EQ(violations(), (Sentences{"reference 0 is in two leaves",
                                     "node 5 does not have the box of its reference",
                                     "reference 1 is in no leaf"}));
}

TEST_F(ValidateTreeOfFour, FindsExchangedLeaves) {
  std::swap(node(4).index, node(5).index);
  EXPECT_EQ(violations(), (Sentences{"node 4 does not have the box of its reference",
                                     "node 5 does not have the box of its reference"}));
}

TEST_F(ValidateTreeOfFour, FindsAChangedReference) {
  references.items[2].lower.y = std::nextafter(references.items[2].lower.y, 2.0f);
  EXPECT_EQ(violations(), Sentences{"node 6 does not have the box of its reference"});
}

/// The six numbers of a box.
float* side(BinaryNode& node, int which) {
  Vec3& corner = which < 3 ? node.lower : node.upper;
  return which % 3 == 0 ? &corner.x : which % 3 == 1 ? &corner.y : &corner.z;
}

TEST_F(ValidateTreeOfFour, FindsAGrownBoxOfALeafOnEachSide) {
  for (int which = 0; which < 6; ++which) {
    const BinaryNode before = node(7);
    *side(node(7), which) += which < 3 ? -10.0f : 10.0f;
    EXPECT_EQ(violations(), (Sentences{"node 3 does not have the union of its children's boxes",
                                       "node 7 does not have the box of its reference"}));
    node(7) = before;
  }
}

TEST_F(ValidateTreeOfFour, FindsABoxOffByOneUnitOnEachSide) {
  for (int which = 0; which < 6; ++which) {
    for (const float towards : {-10.0f, 10.0f}) {
      const BinaryNode before = node(0);
      *side(node(0), which) = std::nextafter(*side(node(0), which), towards);
      EXPECT_EQ(violations(), Sentences{"node 0 does not have the union of its children's boxes"});
      node(0) = before;
    }
  }
}

TEST_F(ValidateTreeOfFour, FindsNan) {
  node(0).upper.z = std::nanf("");
  EXPECT_EQ(violations(), Sentences{"node 0 does not have the union of its children's boxes"});
}

TEST_F(ValidateTreeOfFour, FindsAWrongCount) {
  node(2).count = 3;
  EXPECT_EQ(violations(), (Sentences{"node 0 counts 4 references, its children 5",
                                     "node 2 counts 3 references, its children 2"}));
}

TEST_F(ValidateTreeOfFour, FindsANodeOfNothing) {
  node(4).count = 0;
  EXPECT_EQ(violations(), (Sentences{"node 2 counts 2 references, its children 1",
                                     "node 4 has its children at 0, which is no pair",
                                     "reference 0 is in no leaf"}));
}

TEST_F(ValidateTreeOfFour, FindsChildrenThatAreNoPair) {
  for (const std::uint32_t bad : {0u, 1u, 7u, 8u, 0xffffffffu, 0xfffffffeu}) {
    node(3).index = bad;
    EXPECT_EQ(violations(),
              (Sentences{"node 3 has its children at " + std::to_string(bad) + ", which is no pair",
                         "reference 2 is in no leaf", "reference 3 is in no leaf"}));
  }
}

TEST_F(ValidateTreeOfFour, FindsAPairWithTwoParents) {
  node(3).index = 4;
  EXPECT_EQ(violations(), (Sentences{"the pair 4 has two parents", "reference 2 is in no leaf",
                                     "reference 3 is in no leaf"}));
}

TEST_F(ValidateTreeOfFour, FindsACycle) {
  node(2).index = 2;
  EXPECT_EQ(violations(), (Sentences{"the pair 2 has two parents", "reference 0 is in no leaf",
                                     "reference 1 is in no leaf"}));
}

TEST_F(ValidateTreeOfFour, FindsAWrongNumberOfSlots) {
  const References three = create_references(test::triangle_soup(3, 71).view());
  EXPECT_EQ(validate(tree, three), Sentences{"the tree has 8 slots for 3 references"});
  EXPECT_EQ(validate(BinaryTree(), three), Sentences{"the tree has 0 slots for 3 references"});
}

TEST(Validate, TakesSmallTrees) {
  for (const std::size_t count : {0, 1, 2, 3}) {
    const References references = create_references(test::triangle_soup(count, 72).view());
    EXPECT_TRUE(test::IsSound(test::balanced_tree(references), references)) << count;
  }
}

TEST(Validate, SaysTwentySentencesAtMost) {
  const References references = create_references(test::triangle_soup(100, 73).view());
  BinaryTree tree = test::random_tree(references, 74);
  ASSERT_TRUE(test::IsSound(tree, references));
  tree.nodes[kRoot].index = 3;
  EXPECT_EQ(validate(tree, references).size(), 20u);
  EXPECT_FALSE(test::IsSound(tree, references));
}

}  // namespace
}  // namespace treelet
