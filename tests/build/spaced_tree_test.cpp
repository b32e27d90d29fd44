#include <treelet/build/spaced_tree.h>

#include <gtest/gtest.h>

#include <treelet/tree/refit.h>

#include <cstdint>
#include <vector>

#include "support/trees.h"

namespace treelet {
namespace {

Reference reference_of(std::uint32_t face) {
  const float x = float(face);
  return {{x, 0, 0}, face, {x + 1, 1, 1}, 0};
}

TEST(SpacedTree, LeavesOutFreePlacesAndSortsReferencesByFace) {
  SpacedTree spaced(7);  // places: 7 . 3 . 5 5 .
  spaced.items[0] = reference_of(7);
  spaced.items[2] = reference_of(3);
  spaced.items[4] = spaced.items[5] = reference_of(5);
  const std::uint32_t halves = spaced.set_internal(kRoot, 0, 7, 4);
  const std::uint32_t left = spaced.set_internal(halves, 0, 4, 2);
  const std::uint32_t right = spaced.set_internal(halves + 1, 4, 7, 5);
  spaced.set_leaf(left, 0, 2);
  spaced.set_leaf(left + 1, 2, 4);
  spaced.set_leaf(right, 4, 5);
  spaced.set_leaf(right + 1, 5, 7);

  References references;
  references.may_repeat_faces = true;
  BinaryTree tree = spaced.close_gaps(references);
  refit(tree, references);
  std::vector<std::uint32_t> faces;
  for (const Reference& reference : references.items) faces.push_back(reference.face);
  EXPECT_EQ(faces, (std::vector<std::uint32_t>{3, 5, 5, 7}));
  EXPECT_EQ(test::references_below(tree, kRoot), (std::vector<std::uint32_t>{3, 0, 1, 2}));
  EXPECT_TRUE(test::IsSound(tree, references));
}

TEST(SpacedTree, OfOneLeafIsARoot) {
  SpacedTree spaced(3);
  spaced.items[0] = reference_of(4);
  spaced.set_leaf(kRoot, 0, 3);
  References references;
  const BinaryTree tree = spaced.close_gaps(references);
  EXPECT_EQ(tree.reference_count(), 1u);
  EXPECT_EQ(tree.nodes[kRoot].index, 0u);
  EXPECT_EQ(references.items[0].face, 4u);
}

}  // namespace
}  // namespace treelet
