#include <treelet/optimize/treelet_solver.h>

namespace treelet {
namespace {

void solve_single_leaves(const TreeletLeaves& leaves, TreeletSolution& solution) {
  for (int leaf = 0; leaf < leaves.size; ++leaf) {
    const std::size_t set = std::size_t{1} << leaf;
    solution.boxes[set] = leaves.box[leaf];
    solution.costs[set] = leaves.cost[leaf];
    solution.counts[set] = leaves.count[leaf];
  }
}

struct Partition {
  float cost = std::numeric_limits<float>::infinity();
  std::uint32_t part = 0;
};

Partition find_best_partition(std::uint32_t set, const TreeletSolution& solution) {
  Partition best;
  for_each_partition(set, [&](std::uint32_t part) {  // ascending: the first of equal costs stays
    const float cost = solution.costs[part] + solution.costs[set ^ part];
    if (cost < best.cost) best = {cost, part};
  });
  return best;
}

void solve_subset(std::uint32_t set, const SahModel& sah, TreeletSolution& solution) {
  const std::uint32_t lowest = set & (0 - set), rest = set ^ lowest;
  solution.boxes[set] = merge(solution.boxes[rest], solution.boxes[lowest]);
  solution.counts[set] = solution.counts[rest] + solution.counts[lowest];
  const Partition best = find_best_partition(set, solution);
  solution.parts[set] = std::uint8_t(best.part);
  solution.costs[set] =
      sah.subtree_cost(half_area(solution.boxes[set]), best.cost, solution.counts[set]);
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
