#pragma once

#include <cstdint>

#include <treelet/optimize/subset_tables.h>
#include <treelet/tree/binary_tree.h>
#include <treelet/tree/sah.h>
#include <treelet/core/launch.cuh>
#include <treelet/optimize/warp_lanes.cuh>
#include <treelet/tree/device_node.cuh>

namespace treelet::cuda {

/// Costs of subtrees in device memory, by the pair of a node's children: half as many as by slot,
/// and a cost stays in place when its node moves. Leaves' costs are computed where they are read.
class PairCosts {
 public:
  __device__ PairCosts(float* costs, const SahModel& sah) : costs_(costs), sah_(sah) {}

  __device__ float of(const BinaryNode& node) const {
    return node.is_leaf() ? sah_.leaf_cost(half_area(node.box()), 1) : costs_[node.index / 2];
  }
  __device__ float from_children(const BinaryNode& node, float left, float right) const {
    return sah_.subtree_cost(half_area(node.box()), left + right, node.count);
  }
  __device__ void set(std::uint32_t pair, float cost) const { costs_[pair / 2] = cost; }
  /// By one thread, after the children's.
  __device__ void update(const BinaryNode* nodes, std::uint32_t slot) const {
    const BinaryNode node = load_node(nodes + slot);
    const float left = of(load_node(nodes + node.left()));
    const float right = of(load_node(nodes + node.right()));
    set(node.index, from_children(node, left, right));
  }

 private:
  float* costs_;
  const SahModel& sah_;
};

/// A treelet across the lanes of a warp: what Treelet of treelet_forming.h holds.
///
///     lane     0 1 2 3 4 5 6 7   8 9          lane i of the first eight: leaf i; of the first
///     node     leaves            root's       seven: pair i, as it was opened
///     pair     pairs             children
class WarpTreelet {
 public:
  /// Grows a treelet of up to `limit` leaves below a root whose children are `pair`.
  __device__ WarpTreelet(const BinaryNode* nodes, std::uint32_t pair, int limit)
      : nodes_(nodes), pair_(pair) {
    // As many copies of the first two leaves as fit, so that lanes 8 and 9 have them too.
    take(pair + lane_index() % 2);
    if (lane_index() % kMaxTreeletSize >= 2) area_ = kNeverOpened;
    while (size_ < limit && open_largest()) {
    }
  }

  __device__ int size() const { return size_; }
  /// Of a leaf's lane.
  __device__ const BinaryNode& leaf() const { return node_; }
  /// The i-th pair, modulo 32 and some value where there is none; all lanes call.
  __device__ std::uint32_t pair(std::uint32_t i) const {
    return __shfl_sync(kFullWarp, pair_, int(i % kWarpSize));
  }
  /// Cost of the root as it is now, and of this lane's leaf.
  struct Costs {
    float root, leaf;
  };
  __device__ Costs read_costs(const BinaryNode& root, const PairCosts& costs) const {
    const float cost = costs.of(node_);
    const float left = __shfl_sync(kFullWarp, cost, kMaxTreeletSize);
    const float right = __shfl_sync(kFullWarp, cost, kMaxTreeletSize + 1);
    return {costs.from_children(root, left, right), cost};
  }

 private:
  static constexpr float kNeverOpened = -1.0f;  // below every area
  static constexpr unsigned kLeafLanes = (1u << kMaxTreeletSize) - 1;

  __device__ void take(std::uint32_t slot) {
    node_ = load_node(nodes_ + slot);
    area_ = node_.is_leaf() ? kNeverOpened : half_area(node_.box());
  }

  /// Of leaves of equal area the first one is opened. False where all are leaves of the tree.
  __device__ bool open_largest() {
    const float largest = largest_of_lanes<kMaxTreeletSize>(area_);
    const bool is_largest = area_ == largest && area_ != kNeverOpened;
    const unsigned candidates = __ballot_sync(kFullWarp, is_largest) & kLeafLanes;
    if (candidates == 0) return false;
    const int leaf = __ffs(int(candidates)) - 1;
    const std::uint32_t pair = __shfl_sync(kFullWarp, node_.index, leaf);
    const int lane = int(lane_index());
    if (lane == leaf || lane == size_) take(pair + std::uint32_t(lane == size_));
    if (lane == size_ - 1) pair_ = pair;
    ++size_;
    return true;
  }

  const BinaryNode* nodes_;
  BinaryNode node_;
  float area_;
  std::uint32_t pair_;
  int size_ = 2;
};

}  // namespace treelet::cuda
