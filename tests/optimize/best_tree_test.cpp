#include <treelet/optimize/best_tree.h>

#include <gtest/gtest.h>

#include "support/meshes.h"
#include "support/trees.h"

namespace treelet {
namespace {

TEST(BestTree, RestoresTheCheapest) {
  const References references = create_references(test::triangle_soup(200, 4).view());
  const BinaryTree good = test::balanced_tree(references), chain = test::chain_tree(references);
  ASSERT_LT(sah_cost(good, SahModel{}), sah_cost(chain, SahModel{}));
  const SahModel sah;
  BestTree best(chain, sah);
  EXPECT_FALSE(best.offer(chain));
  EXPECT_TRUE(best.offer(good));
  EXPECT_FALSE(best.offer(chain));
  BinaryTree tree = test::chain_tree(references);
  best.restore(tree);
  EXPECT_TRUE(test::equal_bytes(tree, good));
}

}  // namespace
}  // namespace treelet
