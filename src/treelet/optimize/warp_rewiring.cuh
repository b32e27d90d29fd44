#pragma once

#include <cstdint>

#include <treelet/core/launch.cuh>
#include <treelet/optimize/warp_forming.cuh>
#include <treelet/optimize/warp_lanes.cuh>
#include <treelet/optimize/warp_solver.cuh>

namespace treelet::cuda {

/// Lays a solved treelet out over its own slots, as TreeletRewiring does on the host: the warp
/// walks the new tree together and tells each lane which node is its own; then all nodes are
/// written at once. Lanes from 0 on have the leaves, lanes from Size on the internal nodes.
template <int Size>
class WarpRewiring {
 public:
  __device__ WarpRewiring(BinaryNode* nodes, const PairCosts& costs, const WarpTreelet& treelet,
                          const TreeletScratch<Size>& scratch)
      : nodes_(nodes), costs_(costs), treelet_(treelet), scratch_(scratch) {}

  __device__ void run(std::uint32_t root) {
    assign_nodes();
    write_node(root);
  }

 private:
  static constexpr std::uint32_t kSubsets = TreeletScratch<Size>::kSubsets;
  static constexpr std::uint32_t kChunks = (kSubsets + kWarpSize - 1) / kWarpSize;

  static constexpr std::uint32_t kRootPlace = 0xff;  // others: 2 i and 2 i + 1 for pair i

  /// Depth first, left before right: pairs go to internal nodes in this order. The subsets on the
  /// stack are disjoint and not empty, so that eight bytes hold it; 0 is the empty stack.
  __device__ void assign_nodes() {
    static_assert(Size <= 8);
    std::uint64_t sets = (1u << treelet_.size()) - 1, places = kRootPlace;
    std::uint32_t internal = 0;
    while (sets != 0) {
      const std::uint32_t set = std::uint32_t(sets) & 0xff, place = std::uint32_t(places) & 0xff;
      const bool is_leaf = (set & (set - 1)) == 0;
      if (lane_index() == (is_leaf ? std::uint32_t(__ffs(int(set))) - 1 : Size + internal)) {
        set_ = set;
        place_ = place;
      }
      sets >>= 8;
      places >>= 8;
      if (is_leaf) continue;
      const std::uint32_t part = find_part(set);
      sets = sets << 16 | part << 8 | (set ^ part);
      places = places << 16 | (2 * internal + 1) << 8 | 2 * internal;
      ++internal;
    }
  }

  /// The smallest of the parts whose partition costs least: found again from the costs, since few
  /// subsets are asked for it.
  __device__ std::uint32_t find_part(std::uint32_t set) const {
    const std::uint32_t movable = set & (set - 1);
    if ((movable & (movable - 1)) == 0) return movable;
    float sums[kChunks];
    float least = INFINITY;
    for (std::uint32_t chunk = 0; chunk < kChunks; ++chunk) {
      sums[chunk] = cost_of_partition(set, movable, chunk * kWarpSize + lane_index());
      least = fminf(least, sums[chunk]);
    }
    least = least_of_lanes<kWarpSize>(least);
    for (std::uint32_t chunk = 0; chunk < kChunks; ++chunk) {
      const int lane = first_lane(sums[chunk] == least);
      if (lane < kWarpSize) return chunk * kWarpSize + std::uint32_t(lane);
    }
    return movable;  // not reached: one of the sums is the least
  }

  __device__ float cost_of_partition(std::uint32_t set, std::uint32_t movable,
                                     std::uint32_t part) const {
    const bool is_part = part != 0 && (part & ~movable) == 0;
    return is_part ? scratch_.costs[part] + scratch_.costs[set ^ part] : INFINITY;
  }

  /// All lanes call; those without a node of their own write nothing.
  __device__ void write_node(std::uint32_t root) const {
    const std::uint32_t above = treelet_.pair(place_ / 2),
                        below = treelet_.pair(lane_index() - Size);
    if (set_ == 0) return;
    const std::uint32_t slot = place_ == kRootPlace ? root : above + place_ % 2;
    if (lane_index() < Size) return store_node(nodes_ + slot, treelet_.leaf());
    SubsetSum sum;
    for (int leaf = 0; leaf < Size; ++leaf) {
      if ((set_ >> leaf & 1) != 0) sum.add(load_node(&scratch_.leaves[leaf]));
    }
    store_node(nodes_ + slot, {sum.box.lower, below, sum.box.upper, sum.count});
    costs_.set(below, scratch_.costs[set_]);
  }

  BinaryNode* nodes_;
  const PairCosts& costs_;
  const WarpTreelet& treelet_;
  const TreeletScratch<Size>& scratch_;
  std::uint32_t set_ = 0;  // leaves below this lane's node; 0: it has none
  std::uint32_t place_ = 0;
};

}  // namespace treelet::cuda
