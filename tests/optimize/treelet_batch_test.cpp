#include <treelet/optimize/treelet_batch.h>

#include <gtest/gtest.h>

#include <treelet/build/lbvh.h>
#include <treelet/optimize/pair_costs.h>
#include <treelet/optimize/treelet.h>
#include <treelet/tree/bottom_up.h>
#include <treelet/tree/refit.h>

#include <algorithm>
#include <array>
#include <bit>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "support/isas.h"
#include "support/meshes.h"
#include "support/random.h"
#include "support/trees.h"

namespace treelet {
namespace {

/// Boxes may be flat or points, and counts on both sides of the leaf limit.
TreeletLeaves random_leaves(int size, test::Random& random) {
  TreeletLeaves leaves;
  leaves.size = size;
  for (std::size_t leaf = 0; leaf < std::size_t(size); ++leaf) {
    const Vec3 a = random.point(-1, 1), b = random.point(-1, 1);
    leaves.box[leaf] = {min(a, b), max(a, b)};
    const std::uint64_t kind = random.below(8);
    if (kind == 0) leaves.box[leaf].upper.z = leaves.box[leaf].lower.z;
    if (kind == 1) leaves.box[leaf].upper = leaves.box[leaf].lower;
    leaves.cost[leaf] = random.uniform(0, 20);
    leaves.count[leaf] =
        std::uint32_t(kind == 2 ? 2000000000 + random.below(1000) : 1 + random.below(4));
  }
  return leaves;
}

/// Leaves in a lane of a batch, where the forming kernel would put them.
void set_leaves(TreeletBatch& batch, std::size_t lane, const TreeletLeaves& leaves,
                const SahModel& sah) {
  for (std::size_t leaf = 0; leaf < std::size_t(leaves.size); ++leaf) {
    for (int axis = 0; axis < 3; ++axis) {
      batch.lower[axis][leaf][lane] = leaves.box[leaf].lower[axis];
      batch.upper[axis][leaf][lane] = leaves.box[leaf].upper[axis];
    }
    batch.cost[leaf][lane] = leaves.cost[leaf];
    batch.count[leaf][lane] = float(std::min(leaves.count[leaf], sah.leaf_limit + 1));
  }
}

struct Members {
  std::vector<TreeletLeaves> leaves;
  TreeletBatch batch;

  Members(int size, const SahModel& sah, test::Random& random) {
    batch.size = size;
    for (std::size_t i = 0; i < TreeletBatch::kTreelets; ++i) {
      leaves.push_back(random_leaves(size, random));
      set_leaves(batch, i, leaves.back(), sah);
    }
  }
};

void expect_same_solution(const SolvedTreelet& batched, const TreeletSolution& one, int size) {
  for (std::uint32_t set = 1; set < 1u << size; ++set) {
    ASSERT_EQ(batched.cost(set), one.cost(set)) << "subset " << set;
    if (std::has_single_bit(set)) continue;
    ASSERT_EQ(batched.part(set), one.part(set)) << "subset " << set;
  }
}

void expect_solved_alike(const Members& members, const SahModel& sah, Isa isa) {
  SolvedBatch solved;
  treelet_kernels(isa).solve(members.batch, sah, solved);
  for (std::size_t i = 0; i < TreeletBatch::kTreelets; ++i) {
    TreeletSolution one;
    solve_treelet(members.leaves[i], sah, one);
    expect_same_solution(SolvedTreelet(solved, i), one, members.batch.size);
  }
}

TEST(TreeletBatch, SolvesLikeTheReadableSolverBitForBit) {
  for (const Isa isa : test::runnable_isas()) {
    for (int size = kMinTreeletSize; size <= kMaxTreeletSize; ++size) {
      for (const std::uint32_t leaf_limit : {1u, 8u, 64u}) {
        SCOPED_TRACE("isa " + std::to_string(int(isa)) + ", size " + std::to_string(size) +
                     ", leaf limit " + std::to_string(leaf_limit) + ", seed 5");
        test::Random random(5);
        const SahModel sah{.leaf_limit = leaf_limit};
        for (int repeat = 0; repeat < 20; ++repeat) {
          expect_solved_alike(Members(size, sah, random), sah, isa);
        }
      }
    }
  }
}

TEST(TreeletBatch, TakesTheSmallestOfEqualParts) {
  // Leaves of one box and few costs: nearly all partitions cost the same as others.
  for (const Isa isa : test::runnable_isas()) {
    for (int size = kMinTreeletSize; size <= kMaxTreeletSize; ++size) {
      SCOPED_TRACE("isa " + std::to_string(int(isa)) + ", size " + std::to_string(size));
      test::Random random(6);
      const SahModel sah;
      Members members(size, sah, random);
      for (std::size_t i = 0; i < TreeletBatch::kTreelets; ++i) {
        for (std::size_t leaf = 0; leaf < std::size_t(size); ++leaf) {
          members.leaves[i].box[leaf] = {{0, 0, 0}, {1, 1, float(random.below(2))}};
          members.leaves[i].cost[leaf] = float(random.below(1 + i % 3));
        }
        set_leaves(members.batch, i, members.leaves[i], sah);
      }
      expect_solved_alike(members, sah, isa);
    }
  }
}

/// A tree and the costs of its subtrees.
struct CostedTree {
  SahModel sah;
  BinaryTree tree;
  PairCosts costs;
  std::vector<std::uint32_t> internal;  // children first

  CostedTree(BinaryTree built, const SahModel& model)
      : sah(model), tree(std::move(built)), costs(tree, sah) {
    list_internal_nodes(tree, kRoot, kAllInternal, internal);
    std::reverse(internal.begin(), internal.end());
    for (const std::uint32_t slot : internal) {
      costs.set(tree.nodes[slot].index, costs.from_children(tree, slot));
    }
  }
};

void expect_same_treelet(const TreeletBatch& batch, std::size_t lane, CostedTree& costed) {
  const Treelet treelet = form_treelet(costed.tree, batch.roots[lane], batch.size);
  const TreeletLeaves leaves = gather_leaves(costed.tree, costed.costs, treelet);
  ASSERT_EQ(treelet.size, batch.size);
  EXPECT_EQ(batch.root_cost[lane], costed.costs.from_children(costed.tree, batch.roots[lane]));
  TreeletBatch expected;
  set_leaves(expected, lane, leaves, costed.sah);
  for (std::size_t leaf = 0; leaf < std::size_t(batch.size); ++leaf) {
    if (leaf > 0) {
      ASSERT_EQ(batch.pairs[leaf - 1][lane], treelet.pairs[leaf - 1]);
    }
    ASSERT_EQ(batch.slots[leaf][lane], treelet.leaf_slots[leaf]);
    ASSERT_EQ(batch.cost[leaf][lane], expected.cost[leaf][lane]);
    ASSERT_EQ(batch.count[leaf][lane], expected.count[leaf][lane]);
    for (int axis = 0; axis < 3; ++axis) {
      ASSERT_EQ(batch.lower[axis][leaf][lane], expected.lower[axis][leaf][lane]);
      ASSERT_EQ(batch.upper[axis][leaf][lane], expected.upper[axis][leaf][lane]);
    }
  }
}

/// Forms a treelet at every node that is large enough.
void expect_formed_alike(CostedTree& costed, int size, Isa isa) {
  TreeletBatch batch;
  batch.size = size;
  std::size_t count = 0;
  for (const std::uint32_t root : costed.internal) {
    if (costed.tree.nodes[root].count < std::uint32_t(size)) continue;
    batch.roots[count++] = root;
    if (count == 1) std::fill(std::begin(batch.roots), std::end(batch.roots), root);
    if (count < TreeletBatch::kTreelets && root != costed.internal.back()) continue;
    treelet_kernels(isa).form(costed.tree.nodes.data(), costed.costs.data(), costed.sah, batch);
    for (std::size_t i = 0; i < TreeletBatch::kTreelets; ++i) expect_same_treelet(batch, i, costed);
    count = 0;
  }
}

TEST(TreeletBatch, FormsLikeTheReadableForming) {
  for (const auto& [name, mesh] : test::hard_meshes()) {
    const References references = create_references(mesh.view());
    if (references.size() == 0) continue;
    for (const std::uint32_t leaf_limit : {0u, 8u}) {
      CostedTree built(build_lbvh(references), {.leaf_limit = leaf_limit});
      CostedTree scrambled(test::random_tree(references, 12), {.leaf_limit = leaf_limit});
      for (const Isa isa : test::runnable_isas()) {
        for (const int size : {4, 7, 8}) {
          SCOPED_TRACE(name + ", isa " + std::to_string(int(isa)) + ", size " +
                       std::to_string(size) + ", leaf limit " + std::to_string(leaf_limit));
          expect_formed_alike(built, size, isa);
          expect_formed_alike(scrambled, size, isa);
        }
      }
    }
  }
}

TEST(TreeletBatch, UpdatesCostsFromThoseOfChildren) {
  const References references = create_references(test::triangle_soup(500, 10).view());
  for (const Isa isa : test::runnable_isas()) {
    CostedTree costed(build_lbvh(references), {});
    const Array<float> expected = compute_costs(costed.tree, costed.sah);
    PairCosts costs(costed.tree, costed.sah);
    for (const std::uint32_t slot : costed.internal) {
      std::array<std::uint32_t, TreeletBatch::kTreelets> slots;
      slots.fill(slot);
      treelet_kernels(isa).update_costs(costed.tree.nodes.data(), slots.data(), costed.sah,
                                        costs.data());
      ASSERT_EQ(costs.of(costed.tree.nodes[slot]), expected[slot]) << "isa " << int(isa);
    }
  }
}

TEST(TreeletBatch, RestructuresLikeOneByOneByteForByte) {
  std::vector<test::NamedMesh> meshes = test::hard_meshes();
  meshes.push_back({"soup20k", test::triangle_soup(20000, 9)});  // several subtrees and a top
  for (const auto& [name, mesh] : meshes) {
    for (const TreeletConfig& config : {TreeletConfig{}, TreeletConfig{.size = 8, .rounds = 2},
                                        TreeletConfig{.size = 5, .gamma = 2}}) {
      SCOPED_TRACE(name + ", size " + std::to_string(config.size));
      const References references = create_references(mesh.view());
      BinaryTree batched = build_lbvh(references), one_by_one = build_lbvh(references);
      restructure_treelets(batched, {}, config);
      restructure_treelets_one_by_one(one_by_one, {}, config);
      EXPECT_TRUE(test::equal_bytes(batched, one_by_one));
    }
  }
}

}  // namespace
}  // namespace treelet
