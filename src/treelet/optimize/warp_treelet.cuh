#pragma once

#include <cstdint>

#include <treelet/tree/binary_tree.h>
#include <treelet/tree/sah.h>
#include <treelet/core/launch.cuh>
#include <treelet/optimize/warp_forming.cuh>
#include <treelet/optimize/warp_rewiring.cuh>
#include <treelet/optimize/warp_solver.cuh>
#include <treelet/tree/device_node.cuh>

// Work for 7 leaves, counted in the code for sm_90: about 320 instructions to form a treelet, 800
// to solve it, and where it is replaced 800 to rewire it. It reads 13 nodes and up to 9 costs, 0.7
// KB in sectors, and writes as many. Three rounds from gamma 7 have 0.25 to 0.5 treelets a
// reference, over half of them in the first: per reference some 500 instructions, 0.3 KB read and
// 0.3 KB written.

namespace treelet::cuda {

/// What all treelets of a run share, and the scratch of one warp.
template <int Size>
class WarpRestructuring {
 public:
  __device__ WarpRestructuring(BinaryNode* nodes, float* costs, const SahModel& sah,
                               TreeletScratch<Size>& scratch)
      : nodes_(nodes), costs_(costs, sah), scratch_(scratch), solver_(scratch, sah) {}

  /// Replaces the treelet below an internal node where another topology is cheaper, and brings the
  /// node's cost up to date. All lanes call; they must have the nodes and costs below in sight.
  __device__ void restructure(std::uint32_t root) {
    const BinaryNode node = load_node(nodes_ + root);
    const WarpTreelet treelet(nodes_, node.index, Size);
    const WarpTreelet::Costs costs = treelet.read_costs(node, costs_);
    if (treelet.size() < 3) return write_cost(node, costs.root);  // two leaves: one topology
    copy_leaf(treelet, costs.leaf);
    solver_.solve();
    const bool is_better = scratch_.costs[(1u << treelet.size()) - 1] < costs.root;
    if (!is_better) return write_cost(node, costs.root);
    WarpRewiring<Size>(nodes_, costs_, treelet, scratch_).run(root);
  }

 private:
  __device__ void write_cost(const BinaryNode& node, float cost) {
    if (lane_index() == 0) costs_.set(node.index, cost);
  }

  __device__ void copy_leaf(const WarpTreelet& treelet, float cost) {
    __syncwarp();  // lanes may still be reading the treelet before
    if (lane_index() >= Size) return;
    store_node(&scratch_.leaves[lane_index()], treelet.leaf());
    scratch_.costs[1u << lane_index()] = cost;
  }

  BinaryNode* nodes_;
  PairCosts costs_;
  TreeletScratch<Size>& scratch_;
  WarpSolver<Size> solver_;
};

}  // namespace treelet::cuda
