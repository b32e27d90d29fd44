#include <treelet/optimize/treelet.h>

#include <gtest/gtest.h>

#include <treelet/build/lbvh.h>
#include <treelet/optimize/treelet_solver.h>
#include <treelet/tree/refit.h>
#include <treelet/tree/validate.h>

#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "support/mesh_params.h"
#include "support/meshes.h"
#include "support/random.h"
#include "support/threads.h"
#include "support/trees.h"

namespace treelet {
namespace {

BinaryTree copy_of(const BinaryTree& tree) {
  BinaryTree copy;
  copy.nodes = tree.nodes.clone();
  return copy;
}

std::vector<Aabb> random_boxes(std::size_t count, std::uint64_t seed) {
  test::Random random(seed);
  std::vector<Aabb> boxes;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 lower = random.point(0.0f, 1.0f);
    boxes.push_back({lower, lower + random.point(0.0f, 0.2f)});
  }
  return boxes;
}

/// The least cost of any tree over up to eight references. The solver has its own proof against
/// enumeration.
float least_cost(const References& references, const SahModel& sah) {
  TreeletLeaves leaves;
  leaves.size = int(references.size());
  for (std::size_t i = 0; i < references.size(); ++i) {
    leaves.box[i] = references.items[i].box();
    leaves.cost[i] = sah.leaf_cost(half_area(leaves.box[i]), 1);
    leaves.count[i] = 1;
  }
  TreeletSolution solution;
  solve_treelet(leaves, sah, solution);
  return solution.cost((1u << leaves.size) - 1);
}

float root_cost(const BinaryTree& tree, const SahModel& sah) {
  return tree.empty() ? 0.0f : compute_costs(tree, sah)[kRoot];
}

class RestructureHardMesh : public testing::TestWithParam<test::NamedMesh> {
 protected:
  const References references_ = create_references(GetParam().mesh.view());
};

TEST_P(RestructureHardMesh, NeverRaisesTheCostAndStaysSound) {
  const SahModel sah;
  for (const bool scrambled : {false, true}) {
    const BinaryTree built =
        scrambled ? test::random_tree(references_, 11) : build_lbvh(references_);
    const float before = root_cost(built, sah);
    for (int size = kMinTreeletSize; size <= kMaxTreeletSize; ++size) {
      for (const std::uint32_t gamma : {0u, 1u, 16u, 1000000000u}) {
        SCOPED_TRACE("size " + std::to_string(size) + ", gamma " + std::to_string(gamma) +
                     ", scrambled " + std::to_string(scrambled));
        BinaryTree tree = copy_of(built);
        restructure_treelets(tree, sah, {.size = size, .rounds = 3, .gamma = gamma});
        EXPECT_LE(root_cost(tree, sah), before);
        EXPECT_EQ(validate(tree, references_), std::vector<std::string>{});
      }
    }
  }
}

TEST_P(RestructureHardMesh, MoreRoundsNeverCostMore) {
  const SahModel sah;
  float previous = root_cost(build_lbvh(references_), sah);
  for (int rounds = 0; rounds <= 5; ++rounds) {
    BinaryTree tree = build_lbvh(references_);
    restructure_treelets(tree, sah, {.rounds = rounds});
    EXPECT_LE(root_cost(tree, sah), previous) << rounds << " rounds";
    EXPECT_EQ(validate(tree, references_), std::vector<std::string>{}) << rounds << " rounds";
    previous = root_cost(tree, sah);
  }
}

TEST_P(RestructureHardMesh, WithoutRoundsNothingChanges) {
  const BinaryTree built = build_lbvh(references_);
  BinaryTree tree = copy_of(built);
  restructure_treelets(tree, {}, {.rounds = 0});
  EXPECT_TRUE(test::equal_bytes(tree, built));
}

INSTANTIATE_TEST_SUITE_P(Meshes, RestructureHardMesh, testing::ValuesIn(test::hard_meshes()),
                         test::mesh_name);

TEST(Restructure, TellsInterleavedHalvesApart) {
  // The two clusters 0 1 and 100 101, paired across: (0 100) (1 101).
  const auto cube = [](float x) { return Aabb{{x, 0, 0}, {x + 1, 1, 1}}; };
  const References references = test::references_of({cube(0), cube(1), cube(100), cube(101)});
  const SahModel sah{.leaf_limit = 1};
  BinaryTree tree = test::balanced_tree(references, {0, 2, 1, 3});
  const float interleaved = root_cost(tree, sah);
  restructure_treelets(tree, sah, {.size = 4, .rounds = 1});
  EXPECT_LT(root_cost(tree, sah), 0.7f * interleaved);
  EXPECT_EQ(root_cost(tree, sah), least_cost(references, sah));
  const BinaryNode& left = tree.nodes[tree.nodes[kRoot].left()];
  EXPECT_EQ(left.count, 2u);
  EXPECT_EQ(left.box(), (Aabb{{0, 0, 0}, {2, 1, 1}}));
}

TEST(Restructure, ATreeOfOneTreeletBecomesOptimal) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const std::size_t count = 4 + seed % 5;
    SCOPED_TRACE("seed " + std::to_string(seed) + ", references " + std::to_string(count));
    const References references = test::references_of(random_boxes(count, seed));
    const SahModel sah{.leaf_limit = seed % 2 == 0 ? 1u : 8u};
    BinaryTree tree = test::random_tree(references, seed);
    restructure_treelets(tree, sah, {.size = int(count), .rounds = 1});
    EXPECT_EQ(root_cost(tree, sah), least_cost(references, sah));
    EXPECT_EQ(validate(tree, references), std::vector<std::string>{});
  }
}

TEST(Restructure, LeavesOfSmallTreesAreKept) {
  for (std::size_t count = 0; count <= 3; ++count) {
    const References references = test::references_of(random_boxes(count, count));
    BinaryTree tree = test::random_tree(references, 5);
    restructure_treelets(tree, {}, {.size = 4, .rounds = 5, .gamma = 1});
    EXPECT_EQ(validate(tree, references), std::vector<std::string>{});
  }
}

TEST(Restructure, GammaBoundsTheRootsThatAreTouched) {
  // Only nodes of at least 512 references are roots in the only round: a scrambled subtree of
  // fewer, below a treelet of eight leaves, may move but its inside stays.
  const References references = test::references_of(random_boxes(2000, 3));
  const BinaryTree built = test::random_tree(references, 3);
  const SahModel sah;
  float previous = root_cost(built, sah);
  for (const std::uint32_t gamma : {2000u, 512u, 64u, 8u}) {
    BinaryTree tree = copy_of(built);
    restructure_treelets(tree, sah, {.rounds = 1, .gamma = gamma});
    EXPECT_LT(root_cost(tree, sah), previous) << "gamma " << gamma;
    previous = root_cost(tree, sah);
  }
  BinaryTree tree = copy_of(built);
  restructure_treelets(tree, sah, {.rounds = 16, .gamma = 2001});
  EXPECT_TRUE(test::equal_bytes(tree, built));
}

TEST(Restructure, GammaDoublesEachRound) {
  // Round r works from gamma 2^r on: with gamma a little over half the references, the second round
  // has no root any more and two rounds do what one does.
  const References references = test::references_of(random_boxes(1000, 4));
  const BinaryTree built = test::random_tree(references, 4);
  const auto run = [&](int rounds, std::uint32_t gamma) {
    BinaryTree tree = copy_of(built);
    restructure_treelets(tree, {}, {.rounds = rounds, .gamma = gamma});
    return tree;
  };
  EXPECT_TRUE(test::equal_bytes(run(1, 501), run(9, 501)));
  EXPECT_FALSE(test::equal_bytes(run(1, 16), run(2, 16)));
  BinaryTree in_turn = run(1, 16);
  restructure_treelets(in_turn, {}, {.rounds = 1, .gamma = 32});
  EXPECT_TRUE(test::equal_bytes(in_turn, run(2, 16)));
}

TEST(Restructure, ScrambledTreesGetMuchBetter) {
  const References references = test::references_of(random_boxes(4000, 6));
  const SahModel sah;
  BinaryTree tree = test::random_tree(references, 6);
  const float before = root_cost(tree, sah);
  restructure_treelets(tree, sah, {.rounds = 6});
  EXPECT_LT(root_cost(tree, sah), 0.5f * before);
}

TEST(Restructure, TreesDeeperThanAnyStackAreFine) {
  const References references = test::references_of(random_boxes(20000, 7));
  BinaryTree tree = test::chain_tree(references);
  const float before = root_cost(tree, {});
  restructure_treelets(tree, {}, {.rounds = 2});
  EXPECT_LT(root_cost(tree, {}), before);
  EXPECT_EQ(validate(tree, references), std::vector<std::string>{});
}

TEST(Restructure, GivesTheSameBytesForAnyNumberOfThreads) {
  const References references = create_references(test::triangle_soup(20000, 8).view());
  BinaryTree expected;
  for (const unsigned threads : {1u, 2u, 3u, 7u}) {
    const test::ThreadCountScope scope(threads);
    BinaryTree tree = build_lbvh(references);
    restructure_treelets(tree, {}, {});
    if (threads == 1) expected = copy_of(tree);
    EXPECT_TRUE(test::equal_bytes(tree, expected)) << threads << " threads";
  }
}

TEST(RestructureTreelets, RefusesSizesThatItsTablesDoNotHold) {
  BinaryTree tree;
  for (const int size : {3, 9, -1}) {
    try {
      restructure_treelets(tree, {}, {.size = size});
      ADD_FAILURE() << "size " << size << " was accepted";
    } catch (const std::invalid_argument& error) {
      EXPECT_EQ(error.what(), "treelets have 4 to 8 leaves, not " + std::to_string(size));
    }
  }
}

}  // namespace
}  // namespace treelet
