#pragma once

#include <array>
#include <cstdint>

#include <treelet/core/isa.h>
#include <treelet/optimize/treelet_solver.h>
#include <treelet/tree/sah.h>

namespace treelet {

/// Sixteen treelets of one size, side by side: one treelet a lane.
struct TreeletBatch {
  static constexpr int kTreelets = 16;

  int size = 0;
  alignas(64) float lower[3][kMaxTreeletSize][kTreelets];
  alignas(64) float upper[3][kMaxTreeletSize][kTreelets];
  alignas(64) float cost[kMaxTreeletSize][kTreelets];
  alignas(64) float count[kMaxTreeletSize][kTreelets];  ///< no larger than leaf_limit + 1

  void set(int treelet, const TreeletLeaves& leaves, const SahModel& sah);
};

/// Cost of the best subtree over each subset of the leaves, for each treelet of a batch.
struct TreeletBatchCosts {
  alignas(64) float cost[TreeletSolution::kSubsets][TreeletBatch::kTreelets];
};

/// Gives the costs that solve_treelet gives, bit for bit.
using TreeletBatchSolver = void (*)(const TreeletBatch& batch, const SahModel& sah,
                                    TreeletBatchCosts& costs);

TreeletBatchSolver treelet_batch_solver(Isa isa);

/// One treelet's solution, its parts found again from the costs where they are needed: that is
/// in the few subsets of the best tree.
class TreeletBatchSolution {
 public:
  TreeletBatchSolution(const TreeletBatchCosts& costs, int treelet, const TreeletLeaves& leaves)
      : costs_(costs), treelet_(treelet), leaves_(leaves) {}

  float cost(std::uint32_t set) const { return costs_.cost[set][treelet_]; }
  std::uint32_t part(std::uint32_t set) const;
  Aabb box(std::uint32_t set) const;
  std::uint32_t count(std::uint32_t set) const;

 private:
  const TreeletBatchCosts& costs_;
  int treelet_;
  const TreeletLeaves& leaves_;
};

}  // namespace treelet
