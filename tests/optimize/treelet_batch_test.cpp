#include <treelet/optimize/treelet_batch.h>

#include <gtest/gtest.h>

#include <treelet/build/lbvh.h>
#include <treelet/optimize/treelet.h>
#include <treelet/tree/refit.h>

#include <bit>
#include <string>
#include <vector>

#include "support/meshes.h"
#include "support/random.h"
#include "support/trees.h"

namespace treelet {
namespace {

std::vector<Isa> runnable_isas() {
  std::vector<Isa> isas;
  for (const Isa isa : {Isa::baseline, Isa::avx2, Isa::avx512}) {
    if (isa <= best_isa()) isas.push_back(isa);
  }
  return isas;
}

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

struct Members {
  std::vector<TreeletLeaves> leaves;
  TreeletBatch batch;

  Members(int size, const SahModel& sah, test::Random& random) {
    batch.size = size;
    for (int i = 0; i < TreeletBatch::kTreelets; ++i) {
      leaves.push_back(random_leaves(size, random));
      batch.set(i, leaves.back(), sah);
    }
  }
};

void expect_same_solution(const TreeletBatchSolution& batched, const TreeletSolution& one,
                          int size) {
  for (std::uint32_t set = 1; set < 1u << size; ++set) {
    ASSERT_EQ(batched.cost(set), one.cost(set)) << "subset " << set;
    ASSERT_EQ(batched.box(set), one.box(set)) << "subset " << set;
    ASSERT_EQ(batched.count(set), one.count(set)) << "subset " << set;
    if (std::has_single_bit(set)) continue;
    ASSERT_EQ(batched.part(set), one.part(set)) << "subset " << set;
  }
}

TEST(TreeletBatch, SolvesLikeTheReadableSolverBitForBit) {
  for (const Isa isa : runnable_isas()) {
    for (int size = kMinTreeletSize; size <= kMaxTreeletSize; ++size) {
      for (const std::uint32_t leaf_limit : {1u, 8u, 64u}) {
        SCOPED_TRACE("isa " + std::to_string(int(isa)) + ", size " + std::to_string(size) +
                     ", leaf limit " + std::to_string(leaf_limit) + ", seed 5");
        test::Random random(5);
        const SahModel sah{.leaf_limit = leaf_limit};
        const Members members(size, sah, random);
        TreeletBatchCosts costs;
        treelet_batch_solver(isa)(members.batch, sah, costs);
        for (int i = 0; i < TreeletBatch::kTreelets; ++i) {
          const TreeletLeaves& leaves = members.leaves[std::size_t(i)];
          TreeletSolution one;
          solve_treelet(leaves, sah, one);
          expect_same_solution(TreeletBatchSolution(costs, i, leaves), one, size);
        }
      }
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
