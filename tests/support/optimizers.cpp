#include "support/optimizers.h"

#include <gtest/gtest.h>

#include <treelet/build/lbvh.h>
#include <treelet/tree/refit.h>

#include "support/meshes.h"
#include "support/threads.h"
#include "support/trees.h"

namespace treelet::test {

std::vector<BinaryTree> trees_over(const References& references) {
  std::vector<BinaryTree> trees;
  trees.push_back(build_lbvh(references));
  trees.push_back(random_tree(references, 5));
  trees.push_back(chain_tree(references));
  return trees;
}

void expect_sound_and_never_dearer(const Optimizer& optimize) {
  for (const auto& [name, mesh] : hard_meshes()) {
    SCOPED_TRACE(name);
    const References references = create_references(mesh.view());
    for (BinaryTree& tree : trees_over(references)) {
      const double before = sah_cost(tree, SahModel{});
      optimize(tree);
      EXPECT_TRUE(IsSound(tree, references));
      EXPECT_LE(sah_cost(tree, SahModel{}), before * (1.0 + 1e-6));
    }
  }
}

void expect_same_bytes_with_any_threads(const Optimizer& optimize) {
  const References references = create_references(triangle_soup(20'000, 7).view());
  std::vector<BinaryTree> trees;
  for (const unsigned threads : {1, 2, 5}) {
    const ThreadCountScope scope(threads);
    trees.push_back(build_lbvh(references));
    optimize(trees.back());
  }
  for (const BinaryTree& tree : trees) EXPECT_TRUE(equal_bytes(tree, trees[0]));
}

}  // namespace treelet::test
