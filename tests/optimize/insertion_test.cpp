#include <treelet/optimize/insertion.h>

#include <gtest/gtest.h>

#include <treelet/build/sweep.h>
#include <treelet/tree/refit.h>

#include <stdexcept>

#include "support/meshes.h"
#include "support/optimizers.h"
#include "support/trees.h"

namespace treelet {
namespace {

// Two far clusters, half of each in either half of the tree.
TEST(Insertion, ReachesAcrossTheRoot) {
  std::vector<Aabb> boxes;
  for (int i = 0; i < 32; ++i) {
    const float x = float(i) * 2.0f + (i % 2 == 0 ? 0.0f : 1000.0f);
    boxes.push_back({{x, 0, 0}, {x + 1, 1, 1}});
  }
  const References references = test::references_of(boxes);
  BinaryTree tree = test::balanced_tree(references);
  insert_nodes(tree, SahModel{}, {.percent = 20.0f, .batches = 200});
  EXPECT_TRUE(test::IsSound(tree, references));
  EXPECT_LT(sah_cost(tree, SahModel{}), 1.1 * sah_cost(build_sweep(references), SahModel{}));
}

TEST(Insertion, MakesAGoodTreeOfARandomOne) {
  const References references = create_references(test::triangle_soup(3000, 14).view());
  BinaryTree tree = test::random_tree(references, 14);
  insert_nodes(tree, SahModel{}, {.percent = 5.0f, .batches = 200});
  EXPECT_TRUE(test::IsSound(tree, references));
  EXPECT_LT(sah_cost(tree, SahModel{}), 1.02 * sah_cost(build_sweep(references), SahModel{}));
}

TEST(Insertion, KeepsTreesSoundAndNeverRaisesTheCost) {
  for (const float percent : {1.0f, 50.0f}) {
    test::expect_sound_and_never_dearer([&](BinaryTree& tree) {
      insert_nodes(tree, SahModel{}, {.percent = percent, .batches = 8});
    });
  }
}

TEST(Insertion, GivesTheSameBytesWithAnyNumberOfThreads) {
  test::expect_same_bytes_with_any_threads(
      [](BinaryTree& tree) { insert_nodes(tree, SahModel{}, {.batches = 10}); });
}

TEST(Insertion, DoesNothingInNoBatchesOrWithoutNodes) {
  const References references = create_references(test::triangle_soup(500, 3).view());
  for (const InsertionConfig config : {InsertionConfig{.batches = 0}, {.percent = 0.0f}}) {
    BinaryTree tree = test::random_tree(references, 3);
    insert_nodes(tree, SahModel{}, config);
    EXPECT_TRUE(test::equal_bytes(tree, test::random_tree(references, 3)));
  }
}

TEST(Insertion, RefusesBadParameters) {
  BinaryTree tree;
  EXPECT_THROW(insert_nodes(tree, SahModel{}, {.percent = -1.0f}), std::invalid_argument);
  EXPECT_THROW(insert_nodes(tree, SahModel{}, {.percent = 101.0f}), std::invalid_argument);
  EXPECT_THROW(insert_nodes(tree, SahModel{}, {.batches = -1}), std::invalid_argument);
}

}  // namespace
}  // namespace treelet
