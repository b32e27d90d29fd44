#include <treelet/optimize/reinsertion.h>

#include <gtest/gtest.h>

#include <treelet/build/lbvh.h>
#include <treelet/optimize/reinsertion_search.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

#include "support/meshes.h"
#include "support/optimizers.h"
#include "support/trees.h"

namespace treelet {
namespace {

double area_sum_below(const BinaryTree& tree, std::uint32_t slot) {
  const BinaryNode& node = tree.nodes[slot];
  if (node.is_leaf()) return 0.0;
  return half_area(node.box()) + area_sum_below(tree, node.left()) +
         area_sum_below(tree, node.right());
}
double area_sum(const BinaryTree& tree) { return tree.empty() ? 0.0 : area_sum_below(tree, kRoot); }

/// The tree with `from` beside `to`, by definition: what a move would make of the areas.
class Moved {
 public:
  Moved(const BinaryTree& tree, std::uint32_t from, std::uint32_t to)
      : tree_(tree), from_(from), to_(to), sum_(area_sum_below(tree, from)) {
    box_of(kRoot);
  }
  double area_sum() const { return sum_; }

 private:
  Aabb box_of(std::uint32_t slot) {
    Aabb box = box_without(slot);
    if (slot != to_) return box;
    box = merge(box, tree_.nodes[from_].box());
    sum_ += half_area(box);
    return box;
  }

  Aabb box_without(std::uint32_t slot) {
    const BinaryNode& node = tree_.nodes[slot];
    if (node.is_leaf()) return node.box();
    if (node.left() == from_) return box_of(node.right());
    if (node.right() == from_) return box_of(node.left());
    const Aabb left = box_of(node.left());
    const Aabb box = merge(left, box_of(node.right()));
    sum_ += half_area(box);
    return box;
  }

  const BinaryTree& tree_;
  const std::uint32_t from_, to_;
  double sum_;
};

bool is_below(const BinaryTree& tree, std::uint32_t root, std::uint32_t slot) {
  if (root == slot) return true;
  const BinaryNode& node = tree.nodes[root];
  return !node.is_leaf() &&
         (is_below(tree, node.left(), slot) || is_below(tree, node.right(), slot));
}

double best_gain(const LinkedTree& linked, std::uint32_t from) {
  const BinaryTree& tree = linked.tree;
  const double before = area_sum(tree);
  double best = 0.0;
  for (std::uint32_t to = 0; to < tree.nodes.size(); ++to) {
    if (to == 1 || to == linked.parent(from) || is_below(tree, from, to)) continue;
    best = std::max(best, before - Moved(tree, from, to).area_sum());
  }
  return best;
}

TEST(ReinsertionSearch, FindsTheBestOfAllPlaces) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const test::OwnedMesh mesh = test::triangle_soup(4 + 2 * seed, seed);
    const References references = create_references(mesh.view());
    BinaryTree tree = test::random_tree(references, seed);
    const LinkedTree linked(tree);
    ReinsertionSearch search(linked);
    for (std::uint32_t from = 2; from < tree.nodes.size(); ++from) {
      SCOPED_TRACE("seed " + std::to_string(seed) + ", slot " + std::to_string(from));
      const Reinsertion found = search.find(from);
      const double best = best_gain(linked, from), tolerance = 1e-5 * area_sum(tree);
      ASSERT_NEAR(found.gain, best, tolerance);
      if (found.gain == 0.0f) continue;
      ASSERT_NEAR(area_sum(tree) - Moved(tree, from, found.to).area_sum(), best, tolerance);
    }
  }
}

// Two far clusters, each half of them in either half of the tree: only a search that looks across
// the root can part them.
TEST(Reinsertion, ReachesAcrossTheRoot) {
  const auto box_at = [](float x) { return Aabb{{x, 0, 0}, {x + 1, 1, 1}}; };
  const References references =
      test::references_of({box_at(0), box_at(100), box_at(2), box_at(102)});
  BinaryTree tree = test::balanced_tree(references);
  const double whole = half_area(tree.nodes[kRoot].box());
  ASSERT_GT(area_sum(tree), 2.5 * whole);
  reinsert_nodes(tree, SahModel{}, {.percent = 100.0f, .rounds = 2});
  EXPECT_LT(area_sum(tree), 1.2 * whole);
  EXPECT_TRUE(test::IsSound(tree, references));
}

TEST(Reinsertion, KeepsTreesSoundAndNeverEnlargesThem) {
  for (const auto& [name, mesh] : test::hard_meshes()) {
    SCOPED_TRACE(name);
    const References references = create_references(mesh.view());
    for (BinaryTree& tree : test::trees_over(references)) {
      const double before = area_sum(tree);
      reinsert_nodes(tree, SahModel{}, {.percent = 30.0f, .rounds = 2});
      EXPECT_TRUE(test::IsSound(tree, references));
      EXPECT_LE(area_sum(tree), before * (1.0 + 1e-6));
    }
  }
}

TEST(Reinsertion, NeverRaisesTheCost) {
  test::expect_sound_and_never_dearer(
      [](BinaryTree& tree) { reinsert_nodes(tree, SahModel{}, {.percent = 30.0f, .rounds = 2}); });
}

TEST(Reinsertion, GivesTheSameBytesWithAnyNumberOfThreads) {
  test::expect_same_bytes_with_any_threads(
      [](BinaryTree& tree) { reinsert_nodes(tree, SahModel{}, {}); });
}

TEST(Reinsertion, HelpsALinearTree) {
  const test::OwnedMesh mesh = test::triangle_soup(5'000, 11);
  const References references = create_references(mesh.view());
  BinaryTree tree = build_lbvh(references);
  const double before = area_sum(tree);
  reinsert_nodes(tree, SahModel{}, {.percent = 100.0f, .rounds = 3});
  EXPECT_LT(area_sum(tree), 0.9 * before);
}

TEST(Reinsertion, DoesNothingInNoRoundsOrWithoutNodes) {
  const test::OwnedMesh mesh = test::triangle_soup(500, 3);
  const References references = create_references(mesh.view());
  const BinaryTree before = build_lbvh(references);
  for (const ReinsertionConfig config : {ReinsertionConfig{.rounds = 0}, {.percent = 0.0f}}) {
    BinaryTree tree = build_lbvh(references);
    reinsert_nodes(tree, SahModel{}, config);
    EXPECT_EQ(area_sum(tree), area_sum(before));
  }
}

TEST(Reinsertion, RefusesBadParameters) {
  BinaryTree tree;
  EXPECT_THROW(reinsert_nodes(tree, SahModel{}, {.percent = -1.0f}), std::invalid_argument);
  EXPECT_THROW(reinsert_nodes(tree, SahModel{}, {.percent = 101.0f}), std::invalid_argument);
  EXPECT_THROW(reinsert_nodes(tree, SahModel{}, {.rounds = -1}), std::invalid_argument);
}

}  // namespace
}  // namespace treelet
