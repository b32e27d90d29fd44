#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include <treelet/optimize/treelet_schedule.h>
#include <treelet/tree/binary_tree.h>
#include <treelet/tree/sah.h>
#include <treelet/core/launch.cuh>
#include <treelet/optimize/warp_lanes.cuh>
#include <treelet/tree/device_node.cuh>

// The treelet solver as a warp runs it: the recurrence of treelet_solver.h, the same bits. Sums are
// those of the host and minima exact, so it does not matter which lane takes which partition.
//
// A treelet of 7 leaves takes about 800 instructions: 46 partitions in a row at 9 each, two of them
// loads from shared memory, and 230 for the boxes of 128 subsets. The 92 loads of costs take 130
// cycles, since subsets of one size collide in the banks; the best layout found takes 104, but more
// than 26 instructions for its addresses.

namespace treelet::cuda {

/// What a warp keeps of a treelet in shared memory. Bit i of a subset stands for leaf i.
template <int Size>
struct TreeletScratch {
  static constexpr int kSubsets = 1 << Size;

  alignas(sizeof(BinaryNode)) BinaryNode leaves[Size];
  float costs[kSubsets];       ///< of the best subtree; until that is known, half area of the box
  float leaf_costs[kSubsets];  ///< as one leaf
};

struct SubsetSum {
  Aabb box = Aabb::empty();
  std::uint32_t count = 0;

  /// Same as merge(): build space has neither NaN nor -0, and fminf is one instruction.
  __device__ void add(const BinaryNode& node) {
    box.lower = {fminf(box.lower.x, node.lower.x), fminf(box.lower.y, node.lower.y),
                 fminf(box.lower.z, node.lower.z)};
    box.upper = {fmaxf(box.upper.x, node.upper.x), fmaxf(box.upper.y, node.upper.y),
                 fmaxf(box.upper.z, node.upper.z)};
    count += node.count;
  }
};

template <int Size>
class WarpSolver {
 public:
  __device__ WarpSolver(TreeletScratch<Size>& scratch, const SahModel& sah)
      : scratch_(scratch), sah_(sah) {}

  /// Needs the leaves and their costs, at costs[1 << leaf]; gives all other costs. Begins and ends
  /// with __syncwarp. Of a smaller treelet the other leaves may be any boxes: its own subsets do
  /// not see them.
  __device__ void solve() {
    lane_ = opaque_lane_index();
    __syncwarp();
    sum_subsets();
    __syncwarp();
    solve_rounds(std::make_index_sequence<std::size_t(TreeletSchedule<Size>::kRounds)>());
    solve_quads();
    solve_whole();
  }

 private:
  static constexpr int kLaneLeaves = std::min(Size, 5);  // leaves that a lane's bits stand for

  /// A lane has the subsets that begin with its own bits, and sums those leaves once.
  __device__ void sum_subsets() {
    constexpr unsigned kSubsets = TreeletScratch<Size>::kSubsets;
    if (kSubsets < kWarpSize && lane_ >= kSubsets) return;
    SubsetSum low;
    for (int leaf = 0; leaf < kLaneLeaves; ++leaf) {
      if ((lane_ >> leaf & 1) != 0) low.add(load_node(&scratch_.leaves[leaf]));
    }
    for (std::uint32_t high = 0; high < 1u << (Size - kLaneLeaves); ++high) {
      SubsetSum sum = low;
      for (int leaf = kLaneLeaves; leaf < Size; ++leaf) {
        if ((high >> (leaf - kLaneLeaves) & 1) != 0) sum.add(load_node(&scratch_.leaves[leaf]));
      }
      write_sum(high << kLaneLeaves | lane_, sum);
    }
  }

  __device__ void write_sum(std::uint32_t set, const SubsetSum& sum) {
    if ((set & (set - 1)) == 0) return;
    const float area = half_area(sum.box);
    scratch_.costs[set] = area;
    scratch_.leaf_costs[set] = sah_.leaf_cost(area, sum.count);
  }

  template <std::size_t... Round>
  __device__ void solve_rounds(std::index_sequence<Round...>) {
    (solve_round<Round>(), ...);
  }

  template <std::size_t Round>
  __device__ void solve_round() {
    static constexpr TreeletSchedule<Size> kSchedule = make_treelet_schedule<Size>();
    const std::uint32_t set = kSchedule.sets[Round][lane_];
    if (set != 0) {
      Partitions partitions(scratch_, set);
      for_each_partition_of<kSchedule.leaves[Round]>(set, partitions);
      write_cost(set, partitions.least());
    }
    __syncwarp();
  }

  __device__ void solve_quads() {
    const bool is_busy = lane_ < 4 * Size;
    const std::uint32_t set = quad_set<Size>(lane_);
    Partitions partitions(scratch_, set);
    if (is_busy) for_each_partition_of_quad<Size>(lane_, partitions);
    const float least = least_of_lanes<4>(partitions.least());
    if (is_busy && lane_ % 4 == 0) write_cost(set, least);
    __syncwarp();
  }

  __device__ void solve_whole() {
    constexpr std::uint32_t kWhole = TreeletSchedule<Size>::kWhole;
    Partitions partitions(scratch_, kWhole);
    for_each_partition_of_whole<Size>(lane_, partitions);
    const float least = least_of_lanes<kWarpSize>(partitions.least());
    if (lane_ == 0) write_cost(kWhole, least);
    __syncwarp();
  }

  /// Tries the partitions that it is called with.
  class Partitions {
   public:
    __device__ Partitions(const TreeletScratch<Size>& scratch, std::uint32_t set)
        : costs_(scratch.costs), set_(set) {}
    __device__ void operator()(std::uint32_t part) {
      least_ = fminf(least_, costs_[part] + costs_[set_ ^ part]);
    }
    __device__ float least() const { return least_; }

   private:
    const float* costs_;
    std::uint32_t set_;
    float least_ = INFINITY;
  };

  __device__ void write_cost(std::uint32_t set, float children_cost) {
    scratch_.costs[set] =
        fminf(sah_.internal_cost(scratch_.costs[set], children_cost), scratch_.leaf_costs[set]);
  }

  TreeletScratch<Size>& scratch_;
  const SahModel& sah_;
  unsigned lane_ = 0;
};

}  // namespace treelet::cuda
