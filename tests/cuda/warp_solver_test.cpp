#include <treelet/optimize/warp_solver.cuh>

#include <gtest/gtest.h>

#include <bit>
#include <string>
#include <vector>

#include <treelet/optimize/treelet_solver.h>

#include "cuda/device_input.h"
#include "cuda/schedules.h"
#include "support/random.h"

namespace treelet::cuda {
namespace {

using test::kStream;

/// Each warp solves one treelet after the other, as if they lay in a tree.
template <int Size>
__global__ void solve_all(const TreeletLeaves* treelets, std::uint32_t count, SahModel sah,
                          float* costs) {
  __shared__ TreeletScratch<Size> scratches[2];
  TreeletScratch<Size>& scratch = scratches[threadIdx.x / kWarpSize];
  WarpSolver<Size> solver(scratch, sah);
  const std::uint32_t warps = gridDim.x * blockDim.x / kWarpSize;
  for (std::uint32_t i = warp_index(); i < count; i += warps) {
    if (lane_index() < Size) {
      const unsigned leaf = lane_index();
      const Aabb box = treelets[i].box[leaf];
      scratch.leaves[leaf] = {box.lower, 0, box.upper, treelets[i].count[leaf]};
      scratch.costs[1u << leaf] = treelets[i].cost[leaf];
    }
    solver.solve();
    for (unsigned set = lane_index(); set < 1u << Size; set += kWarpSize) {
      costs[i * (1u << Size) + set] = scratch.costs[set];
    }
    __syncwarp();
  }
}

/// Costs by treelet and subset.
template <int Size>
Array<float> solve_on_device(const std::vector<TreeletLeaves>& treelets, const SahModel& sah) {
  const DeviceArray<TreeletLeaves> leaves =
      test::upload_all(std::span<const TreeletLeaves>(treelets));
  DeviceArray<float> costs(treelets.size() << Size, kStream);
  launch(kStream, {3, 2 * kWarpSize}, solve_all<Size>, leaves.data(),
         std::uint32_t(treelets.size()), sah, costs.data());
  return download(costs);
}

Aabb random_box(test::Random& random) {
  const Vec3 lower = random.point(0.0f, 1.0f);
  switch (random.below(4)) {
    case 0:
      return {lower, lower};
    case 1:
      return {{lower.x, lower.y, 0.5f}, {lower.x + random.uniform(0.0f, 0.3f), lower.y, 0.5f}};
    case 2:
      return {{0, 0, 0}, {1, 1, 1}};
    default:
      return {lower, lower + random.point(0.0f, 0.3f)};
  }
}

TreeletLeaves random_leaves(test::Random& random, int size) {
  const bool are_references = random.below(3) == 0;
  TreeletLeaves leaves;
  leaves.size = size;
  leaves.box.fill({{0, 0, 0}, {0, 0, 0}});
  leaves.cost.fill(0.0f);
  leaves.count.fill(0);
  for (std::size_t leaf = 0; leaf < std::size_t(size); ++leaf) {
    leaves.box[leaf] = random_box(random);
    const std::uint64_t most = random.below(4) == 0 ? 100'000'000 : 3;
    leaves.count[leaf] = are_references ? 1 : std::uint32_t(1 + random.below(most));
    leaves.cost[leaf] =
        half_area(leaves.box[leaf]) * (are_references ? 1.0f : random.uniform(0.5f, 9.0f));
  }
  return leaves;
}

std::vector<TreeletLeaves> random_treelets(int size, std::uint64_t seed, std::size_t count) {
  test::Random random(seed);
  std::vector<TreeletLeaves> treelets;
  for (std::size_t i = 0; i < count; ++i) treelets.push_back(random_leaves(random, size));
  return treelets;
}

template <int Size>
void expect_costs_of_the_readable_solver(const SahModel& sah, std::uint64_t seed) {
  SCOPED_TRACE("size " + std::to_string(Size) + ", leaf limit " + std::to_string(sah.leaf_limit) +
               ", seed " + std::to_string(seed));
  const std::vector<TreeletLeaves> treelets = random_treelets(Size, seed, 40);
  const Array<float> costs = solve_on_device<Size>(treelets, sah);
  for (std::size_t i = 0; i < treelets.size(); ++i) {
    TreeletSolution solution;
    solve_treelet(treelets[i], sah, solution);
    for (std::uint32_t set = 1; set < 1u << Size; ++set) {
      ASSERT_EQ(std::bit_cast<std::uint32_t>(costs[(i << Size) + set]),
                std::bit_cast<std::uint32_t>(solution.cost(set)))
          << "treelet " << i << ", subset " << set;
    }
  }
}

TEST(WarpSolver, SolvesLikeTheReadableSolverBitForBit) {
  test::for_each_schedule([](std::uint64_t seed) {
    for (const std::uint32_t leaf_limit : {1u, 8u, 64u}) {
      const SahModel sah{.leaf_limit = leaf_limit};
      expect_costs_of_the_readable_solver<4>(sah, 401 + seed);
      expect_costs_of_the_readable_solver<5>(sah, 411 + seed);
      expect_costs_of_the_readable_solver<6>(sah, 421 + seed);
      expect_costs_of_the_readable_solver<7>(sah, 431 + seed);
      expect_costs_of_the_readable_solver<8>(sah, 441 + seed);
    }
  });
}

struct Subtree {
  Aabb box;
  float cost;
  std::uint32_t count;
};

/// The best of all topologies over a set, each tried: no table, nothing remembered.
Subtree try_all_topologies(const TreeletLeaves& leaves, const SahModel& sah, std::uint32_t set) {
  if (std::has_single_bit(set)) {
    const std::size_t leaf = std::size_t(std::countr_zero(set));
    return {leaves.box[leaf], leaves.cost[leaf], leaves.count[leaf]};
  }
  Subtree best{Aabb::empty(), std::numeric_limits<float>::infinity(), 0};
  for (std::uint32_t part = (set - 1) & set; part != 0; part = (part - 1) & set) {
    if (part < (set ^ part)) continue;
    const Subtree a = try_all_topologies(leaves, sah, part);
    const Subtree b = try_all_topologies(leaves, sah, set ^ part);
    const Aabb box = merge(a.box, b.box);
    const std::uint32_t count = a.count + b.count;
    const float cost = sah.subtree_cost(half_area(box), a.cost + b.cost, count);
    if (cost < best.cost) best = {box, cost, count};
  }
  return best;
}

template <int Size>
void expect_best_of_all_topologies(std::size_t treelets, std::uint64_t seed) {
  SCOPED_TRACE("size " + std::to_string(Size) + ", seed " + std::to_string(seed));
  for (const SahModel& sah : {SahModel{}, SahModel{.leaf_limit = 2}}) {
    const std::vector<TreeletLeaves> leaves = random_treelets(Size, seed, treelets);
    const Array<float> costs = solve_on_device<Size>(leaves, sah);
    for (std::size_t i = 0; i < treelets; ++i) {
      const std::uint32_t whole = (1u << Size) - 1;
      EXPECT_EQ(costs[(i << Size) + whole], try_all_topologies(leaves[i], sah, whole).cost);
    }
  }
}

TEST(WarpSolver, FindsTheBestOfAllTopologies) {
  expect_best_of_all_topologies<4>(30, 451);
  expect_best_of_all_topologies<5>(30, 452);
  expect_best_of_all_topologies<6>(20, 453);
  expect_best_of_all_topologies<7>(6, 454);
}

TEST(WarpSolver, SolvesSmallerTreeletsWhateverTheOtherLeavesAre) {
  const SahModel sah;
  test::Random random(455);
  std::vector<TreeletLeaves> small, padded;
  for (int i = 0; i < 30; ++i) {
    small.push_back(random_leaves(random, 3 + i % 4));
    padded.push_back(random_leaves(random, 7));
    for (std::size_t leaf = 0; leaf < std::size_t(small.back().size); ++leaf) {
      padded.back().box[leaf] = small.back().box[leaf];
      padded.back().cost[leaf] = small.back().cost[leaf];
      padded.back().count[leaf] = small.back().count[leaf];
    }
  }
  const Array<float> costs = solve_on_device<7>(padded, sah);
  for (std::size_t i = 0; i < small.size(); ++i) {
    TreeletSolution solution;
    solve_treelet(small[i], sah, solution);
    const std::uint32_t whole = (1u << small[i].size) - 1;
    EXPECT_EQ(costs[(i << 7) + whole], solution.cost(whole)) << "treelet " << i << ", seed 455";
  }
}

}  // namespace
}  // namespace treelet::cuda
