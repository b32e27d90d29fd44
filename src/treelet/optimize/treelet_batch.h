#pragma once

#include <cstddef>
#include <cstdint>

#include <treelet/core/isa.h>
#include <treelet/optimize/treelet_forming.h>
#include <treelet/optimize/treelet_solver.h>
#include <treelet/tree/binary_tree.h>
#include <treelet/tree/sah.h>

namespace treelet {

/// Sixteen treelets of one size, side by side: one treelet a lane.
struct TreeletBatch {
  static constexpr int kTreelets = 16;

  int size = 0;
  alignas(64) std::uint32_t roots[kTreelets];                       ///< slots
  alignas(64) float root_cost[kTreelets];                           ///< of the topology as it is
  alignas(64) std::uint32_t pairs[kMaxTreeletSize - 1][kTreelets];  ///< as in Treelet
  alignas(64) std::uint32_t slots[kMaxTreeletSize][kTreelets];      ///< of the leaves
  alignas(64) float lower[3][kMaxTreeletSize][kTreelets];
  alignas(64) float upper[3][kMaxTreeletSize][kTreelets];
  alignas(64) float cost[kMaxTreeletSize][kTreelets];
  alignas(64) float count[kMaxTreeletSize][kTreelets];  ///< no larger than leaf_limit + 1
};

/// The best subtree over each subset of the leaves, for each treelet of a batch. Sets of one leaf
/// have no part.
struct SolvedBatch {
  alignas(64) float cost[TreeletSolution::kSubsets][TreeletBatch::kTreelets];
  alignas(64) std::uint32_t part[TreeletSolution::kSubsets][TreeletBatch::kTreelets];
};

/// One treelet of a solved batch, as TreeletSolution.
class SolvedTreelet {
 public:
  SolvedTreelet(const SolvedBatch& batch, std::size_t treelet) : batch_(batch), treelet_(treelet) {}

  float cost(std::uint32_t set) const { return batch_.cost[set][treelet_]; }
  std::uint32_t part(std::uint32_t set) const { return batch_.part[set][treelet_]; }

 private:
  const SolvedBatch& batch_;
  std::size_t treelet_;
};

/// What one instruction set does to sixteen treelets at once. `costs` are by pair (pair_costs.h).
struct TreeletKernels {
  /// Fills the batch but for `size` and `roots`, as form_treelet and gather_leaves do. Each root
  /// has at least `size` references.
  void (*form)(const BinaryNode* nodes, const float* costs, const SahModel& sah,
               TreeletBatch& batch);
  /// Gives what solve_treelet gives, bit for bit.
  void (*solve)(const TreeletBatch& batch, const SahModel& sah, SolvedBatch& solved);
  /// Computes the costs of internal nodes from their children's.
  void (*update_costs)(const BinaryNode* nodes, const std::uint32_t* slots, const SahModel& sah,
                       float* costs);
};

TreeletKernels treelet_kernels(Isa isa);

}  // namespace treelet
