#include <treelet/tree/binary_tree.h>

#include <gtest/gtest.h>

namespace treelet {
namespace {

TEST(BinaryTree, HasTwoSlotsAReference) {
  const BinaryTree tree(5);
  EXPECT_EQ(tree.nodes.size(), 10u);
  EXPECT_EQ(tree.reference_count(), 5u);
  EXPECT_FALSE(tree.empty());
}

TEST(BinaryTree, OfNothingHasNoSlots) {
  EXPECT_TRUE(BinaryTree().empty());
  EXPECT_TRUE(BinaryTree(0).empty());
}

// Its bytes would otherwise differ from build to build.
TEST(BinaryTree, ClearsTheUnusedSlot) {
  for (int i = 0; i < 10; ++i) {
    const BinaryTree tree(1 + i);
    EXPECT_EQ(tree.nodes[1].index, 0u);
    EXPECT_EQ(tree.nodes[1].count, 0u);
    EXPECT_EQ(tree.nodes[1].box(), (Aabb{{0, 0, 0}, {0, 0, 0}}));
  }
}

TEST(BinaryNode, IsALeafIfItHoldsOneReference) {
  EXPECT_TRUE((BinaryNode{{}, 7, {}, 1}).is_leaf());
  EXPECT_FALSE((BinaryNode{{}, 8, {}, 2}).is_leaf());
}

TEST(BinaryNode, HasItsChildrenNextToEachOther) {
  const BinaryNode node{{}, 8, {}, 2};
  EXPECT_EQ(node.left(), 8u);
  EXPECT_EQ(node.right(), 9u);
}

TEST(BinaryNode, KeepsTheBoxItIsGiven) {
  BinaryNode node{{}, 8, {}, 2};
  const Aabb box{{1, 2, 3}, {4, 5, 6}};
  node.set_box(box);
  EXPECT_EQ(node.box(), box);
  EXPECT_EQ(node.index, 8u);
  EXPECT_EQ(node.count, 2u);
}

}  // namespace
}  // namespace treelet
