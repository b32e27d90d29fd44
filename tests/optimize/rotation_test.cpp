#include <treelet/optimize/rotation.h>

#include <gtest/gtest.h>

#include <treelet/build/lbvh.h>
#include <treelet/tree/refit.h>

#include <algorithm>
#include <stdexcept>
#include <utility>
#include <vector>

#include "support/meshes.h"
#include "support/optimizers.h"
#include "support/trees.h"

namespace treelet {
namespace {

BinaryTree with_swapped(const BinaryTree& tree, const References& references, std::uint32_t x,
                        std::uint32_t y) {
  BinaryTree swapped;
  swapped.nodes = tree.nodes.clone();
  std::swap(swapped.nodes[x], swapped.nodes[y]);
  // Counts of the two nodes' parents change.
  for (std::uint32_t slot = 0; slot < swapped.nodes.size(); ++slot) {
    BinaryNode& node = swapped.nodes[slot];
    if (slot != 1 && !node.is_leaf()) {
      node.count = std::uint32_t(test::references_below(swapped, slot).size());
    }
  }
  refit(swapped, references);
  return swapped;
}

/// A child or grandchild of a node and how far below it is.
struct Descendant {
  std::uint32_t slot;
  int depth;
};

std::vector<Descendant> side(const BinaryTree& tree, std::uint32_t child) {
  std::vector<Descendant> side{{child, 1}};
  if (tree.nodes[child].is_leaf()) return side;
  side.push_back({tree.nodes[child].left(), 2});
  side.push_back({tree.nodes[child].right(), 2});
  return side;
}

/// The cost after the best rotation of a whole tree.
double cheapest_rotation(const BinaryTree& tree, const References& references) {
  double least = sah_cost(tree, SahModel{});
  for (std::uint32_t slot = 0; slot < tree.nodes.size(); ++slot) {
    const BinaryNode& node = tree.nodes[slot];
    if (slot == 1 || node.is_leaf()) continue;
    for (const Descendant& x : side(tree, node.left())) {
      for (const Descendant& y : side(tree, node.right())) {
        if (x.depth + y.depth == 2) continue;
        const BinaryTree rotated = with_swapped(tree, references, x.slot, y.slot);
        least = std::min(least, sah_cost(rotated, SahModel{}));
      }
    }
  }
  return least;
}

TEST(Rotation, EndsWhereNoRotationHelps) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const References references = create_references(test::triangle_soup(40, seed).view());
    BinaryTree tree = test::random_tree(references, seed);
    const double before = sah_cost(tree, SahModel{});
    ASSERT_LT(cheapest_rotation(tree, references), before) << "seed " << seed;
    rotate_nodes(tree, SahModel{}, {.rounds = 1000});
    const double after = sah_cost(tree, SahModel{});
    EXPECT_LT(after, before) << "seed " << seed;
    EXPECT_GE(cheapest_rotation(tree, references), after * (1.0 - 1e-5)) << "seed " << seed;
  }
}

TEST(Rotation, KeepsTreesSoundAndNeverRaisesTheCost) {
  test::expect_sound_and_never_dearer([](BinaryTree& tree) { rotate_nodes(tree, SahModel{}); });
  test::expect_sound_and_never_dearer(
      [](BinaryTree& tree) { rotate_nodes(tree, SahModel{}, {.rounds = 2, .anneal = 5}); });
}

TEST(Rotation, GivesTheSameBytesWithAnyNumberOfThreads) {
  test::expect_same_bytes_with_any_threads(
      [](BinaryTree& tree) { rotate_nodes(tree, SahModel{}, {.rounds = 3, .anneal = 3}); });
}

TEST(Rotation, LeavesLocalMinimaByAnnealing) {
  const References references = create_references(test::triangle_soup(3000, 12).view());
  std::vector<BinaryTree> trees;
  for (const RotationConfig config :
       {RotationConfig{}, {.anneal = 30}, {.anneal = 30, .seed = 2}, {.anneal = 30}}) {
    trees.push_back(build_lbvh(references));
    rotate_nodes(trees.back(), SahModel{}, config);
  }
  EXPECT_LT(sah_cost(trees[1], SahModel{}), 0.995 * sah_cost(trees[0], SahModel{}));
  EXPECT_FALSE(test::equal_bytes(trees[1], trees[2]));
  EXPECT_TRUE(test::equal_bytes(trees[1], trees[3]));
}

TEST(Rotation, DoesNothingInNoRounds) {
  const References references = create_references(test::triangle_soup(500, 3).view());
  BinaryTree tree = build_lbvh(references);
  rotate_nodes(tree, SahModel{}, {.rounds = 0});
  EXPECT_TRUE(test::equal_bytes(tree, build_lbvh(references)));
}

TEST(Rotation, RefusesBadParameters) {
  BinaryTree tree;
  EXPECT_THROW(rotate_nodes(tree, SahModel{}, {.rounds = -1}), std::invalid_argument);
  EXPECT_THROW(rotate_nodes(tree, SahModel{}, {.anneal = -1}), std::invalid_argument);
}

}  // namespace
}  // namespace treelet
