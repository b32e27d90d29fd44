#include <treelet/optimize/agglomeration.h>

#include <gtest/gtest.h>

#include <treelet/build/lbvh.h>
#include <treelet/tree/refit.h>

#include <limits>
#include <stdexcept>
#include <vector>

#include "support/meshes.h"
#include "support/optimizers.h"
#include "support/trees.h"

namespace treelet {
namespace {

struct Cluster {
  Aabb box;
  float cost;
  std::uint32_t count;
};

/// The cost of merging the nearest two of all until one is left.
float agglomerate_by_definition(std::vector<Cluster> clusters) {
  while (clusters.size() > 1) {
    std::size_t first = 0, second = 1;
    float least = std::numeric_limits<float>::infinity();
    for (std::size_t b = 1; b < clusters.size(); ++b) {
      for (std::size_t a = 0; a < b; ++a) {
        const float area = half_area(merge(clusters[a].box, clusters[b].box));
        if (!(area < least)) continue;
        least = area;
        first = a;
        second = b;
      }
    }
    const Cluster &a = clusters[first], &b = clusters[second];
    const Cluster merged{merge(a.box, b.box),
                         SahModel{}.subtree_cost(least, a.cost + b.cost, a.count + b.count),
                         a.count + b.count};
    clusters[first] = merged;
    clusters.erase(clusters.begin() + std::ptrdiff_t(second));
  }
  return clusters[0].cost / half_area(clusters[0].box);
}

// One treelet holds the whole tree: its leaves are the references.
TEST(Agglomeration, MergesTheNearest) {
  int replaced = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    const References references = create_references(test::triangle_soup(20, seed).view());
    std::vector<Cluster> leaves;
    for (const Reference& reference : references.items) {
      leaves.push_back({reference.box(), half_area(reference.box()), 1});
    }
    const double expected = agglomerate_by_definition(leaves);
    BinaryTree tree = test::random_tree(references, seed);
    // Restructuring what lies below the root first must not change what its treelet's leaves are.
    agglomerate_treelets(tree, SahModel{}, {.size = kMaxAgglomeratedSize, .rounds = 1});
    const double cost = sah_cost(tree, SahModel{});
    EXPECT_LE(cost, expected * (1.0 + 1e-5)) << "seed " << seed;
    replaced += cost > expected * (1.0 - 1e-5);
  }
  EXPECT_GT(replaced, 20);  // the others were better as they were
}

TEST(Agglomeration, KeepsTreesSoundAndNeverRaisesTheCost) {
  for (const int size : {kMinAgglomeratedSize, 9, kMaxAgglomeratedSize}) {
    test::expect_sound_and_never_dearer([&](BinaryTree& tree) {
      agglomerate_treelets(tree, SahModel{}, {.size = size, .rounds = 2});
    });
  }
}

TEST(Agglomeration, GivesTheSameBytesWithAnyNumberOfThreads) {
  test::expect_same_bytes_with_any_threads(
      [](BinaryTree& tree) { agglomerate_treelets(tree, SahModel{}); });
}

TEST(Agglomeration, HelpsMoreWithLargerTreelets) {
  const References references = create_references(test::triangle_soup(5000, 12).view());
  double before = sah_cost(build_lbvh(references), SahModel{});
  for (const int size : {4, 9, 20}) {
    BinaryTree tree = build_lbvh(references);
    agglomerate_treelets(tree, SahModel{}, {.size = size});
    const double cost = sah_cost(tree, SahModel{});
    EXPECT_LT(cost, 0.99 * before) << size;
    before = cost;
  }
}

TEST(Agglomeration, RefusesBadParameters) {
  BinaryTree tree;
  EXPECT_THROW(agglomerate_treelets(tree, SahModel{}, {.size = 2}), std::invalid_argument);
  EXPECT_THROW(agglomerate_treelets(tree, SahModel{}, {.size = 33}), std::invalid_argument);
  EXPECT_THROW(agglomerate_treelets(tree, SahModel{}, {.rounds = -1}), std::invalid_argument);
}

}  // namespace
}  // namespace treelet
