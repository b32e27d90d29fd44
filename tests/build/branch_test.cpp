#include <treelet/build/branch.h>

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <vector>

#include "support/trees.h"

namespace treelet {
namespace {

BinaryNode leaf_of(std::uint32_t face) {
  const float x = float(face);
  return {{x, 0, 0}, face, {x + 1, 1, 1}, 1};
}

/// In a top, the leaf in which a branch hangs.
BinaryNode hang(std::uint32_t branch) { return {{}, branch, {}, 0}; }

TEST(Branch, JoinedUnderATopGivesReferencesByFace) {
  std::array<Branch, 2> branches;  // from left to right: 7 (3 5), 5
  const std::uint32_t halves = branches[1].set_internal(kRoot);
  branches[1].set_leaf(halves, leaf_of(7));
  const std::uint32_t right = branches[1].set_internal(halves + 1);
  branches[1].set_leaf(right, leaf_of(3));
  branches[1].set_leaf(right + 1, leaf_of(5));
  branches[0].set_leaf(kRoot, leaf_of(5));
  for (Branch& branch : branches) branch.sum_up();
  Branch top;
  const std::uint32_t hung = top.set_internal(kRoot);
  top.set_leaf(hung, hang(1));
  top.set_leaf(hung + 1, hang(0));

  References references;
  references.may_repeat_faces = true;
  const BinaryTree tree = join_branches(top, branches, references);
  std::vector<std::uint32_t> faces;
  for (const Reference& reference : references.items) faces.push_back(reference.face);
  EXPECT_EQ(faces, (std::vector<std::uint32_t>{3, 5, 5, 7}));
  EXPECT_EQ(test::references_below(tree, kRoot), (std::vector<std::uint32_t>{3, 0, 1, 2}));
  EXPECT_TRUE(test::IsSound(tree, references));
}

TEST(Branch, OfOneLeafIsARoot) {
  std::array<Branch, 1> branches;
  branches[0].set_leaf(kRoot, leaf_of(4));
  Branch top;
  top.set_leaf(kRoot, hang(0));
  References references;
  const BinaryTree tree = join_branches(top, branches, references);
  EXPECT_EQ(tree.reference_count(), 1u);
  EXPECT_EQ(tree.nodes[kRoot].index, 0u);
  EXPECT_EQ(references.items[0].face, 4u);
}

}  // namespace
}  // namespace treelet
