#include <treelet/optimize/treelet_solver.h>

namespace treelet {
namespace {

void solve_single_leaves(const TreeletLeaves& leaves, TreeletSolution& solution) {
  for (int leaf = 0; leaf < leaves.size; ++leaf) {
    const std::size_t set = std::size_t{1} << leaf;
    solution.box[set] = leaves.box[leaf];
    solution.cost[set] = leaves.cost[leaf];
    solution.count[set] = leaves.count[leaf];
  }
}

struct Partition {
  float cost = std::numeric_limits<float>::infinity();
  std::uint32_t part = 0;
};

Partition find_best_partition(std::uint32_t set, const TreeletSolution& solution) {
  Partition best;
  for_each_partition(set, [&](std::uint32_t part) {  // ascending: the first of equal costs stays
    const float cost = solution.cost[part] + solution.cost[set ^ part];
    if (cost < best.cost) best = {cost, part};
  });
  return best;
}

void solve_subset(std::uint32_t set, const SahModel& sah, TreeletSolution& solution) {
  const std::uint32_t lowest = set & (0 - set), rest = set ^ lowest;
  solution.box[set] = merge(solution.box[rest], solution.box[lowest]);
  solution.count[set] = solution.count[rest] + solution.count[lowest];
  const Partition best = find_best_partition(set, solution);
  solution.part[set] = std::uint8_t(best.part);
  solution.cost[set] =
      sah.subtree_cost(half_area(solution.box[set]), best.cost, solution.count[set]);
}

}  // namespace

void solve_treelet(const TreeletLeaves& leaves, const SahModel& sah, TreeletSolution& solution) {
  solve_single_leaves(leaves, solution);
  const std::uint32_t subsets = 1u << leaves.size;
  for (std::uint32_t set = 3; set < subsets; ++set) {  // all parts of a set are smaller numbers
    if (std::has_single_bit(set)) continue;
    solve_subset(set, sah, solution);
  }
}

}  // namespace treelet
