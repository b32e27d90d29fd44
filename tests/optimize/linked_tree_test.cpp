#include <treelet/optimize/linked_tree.h>

#include <gtest/gtest.h>

#include "support/meshes.h"
#include "support/random.h"
#include "support/trees.h"

namespace treelet {
namespace {

bool is_below(const LinkedTree& linked, std::uint32_t slot, std::uint32_t root) {
  while (slot != root && slot != kRoot) slot = linked.parent(slot);
  return slot == root;
}

TEST(LinkedTree, StaysSoundWhateverIsMoved) {
  const References references = create_references(test::triangle_soup(60, 8).view());
  BinaryTree tree = test::random_tree(references, 8);
  LinkedTree linked(tree);
  test::Random random(9);
  int moves = 0;
  for (int trial = 0; trial < 1000; ++trial) {
    const auto from = std::uint32_t(2 + random.below(tree.nodes.size() - 2));
    const auto to = std::uint32_t(2 + random.below(tree.nodes.size() - 2));
    const bool is_gone = to / 2 == from / 2 || to == linked.parent(from);
    if (is_gone || is_below(linked, to, from)) continue;
    ++moves;
    const BinaryNode node = tree.nodes[from];
    linked.remove(from);
    linked.insert(node, to, from & ~1u);
    ASSERT_TRUE(test::IsSound(tree, references)) << "seeds 8, 9, trial " << trial;
    for (std::uint32_t slot = 2; slot < tree.nodes.size(); ++slot) {
      ASSERT_EQ(tree.nodes[linked.parent(slot)].left(), slot & ~1u) << "trial " << trial;
    }
  }
  EXPECT_GT(moves, 500);
}

}  // namespace
}  // namespace treelet
