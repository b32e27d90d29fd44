#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <treelet/build/hploc_steps.h>
#include <treelet/core/launch.cuh>
#include <treelet/tree/device_node.cuh>

namespace treelet::cuda {

static_assert(kHplocLanes == kWarpSize);

/// A node of the radix tree where clusters meet: references [first, last] in Morton order, of which
/// those of the left child end at `split`.
struct Meeting {
  std::uint32_t first, split, last;

  __device__ std::uint32_t count() const { return last - first + 1; }
};

/// The lane of the bit that has n set bits below it; any lane where there is none.
__device__ inline int lane_of_bit(unsigned bits, unsigned n) {
  unsigned lane = 0;
  for (unsigned width = kWarpSize / 2; width > 0; width /= 2) {
    const auto below = unsigned(__popc(bits >> lane & ((1u << width) - 1)));
    if (n < below) continue;
    n -= below;
    lane += width;
  }
  return int(lane);
}

__device__ inline BinaryNode node_of_lane(const BinaryNode& node, int lane) {
  const auto get = [&](auto value) { return __shfl_sync(kFullWarp, value, lane); };
  return {{get(node.lower.x), get(node.lower.y), get(node.lower.z)},
          get(node.index),
          {get(node.upper.x), get(node.upper.y), get(node.upper.z)},
          get(node.count)};
}

/// The box of a lane that lies `distance` above, merged with this lane's. Same as merge(): build
/// space has neither NaN nor -0, and fminf is one instruction.
__device__ inline Aabb merge_with_lane_above(const Aabb& box, unsigned distance) {
  const auto least = [&](float x) { return fminf(x, __shfl_down_sync(kFullWarp, x, distance)); };
  const auto most = [&](float x) { return fmaxf(x, __shfl_down_sync(kFullWarp, x, distance)); };
  return {{least(box.lower.x), least(box.lower.y), least(box.lower.z)},
          {most(box.upper.x), most(box.upper.y), most(box.upper.z)}};
}

/// The clusters that meet at a node, one a lane: what ClusterGroup is on the host. All lanes call.
class WarpClusters {
 public:
  __device__ WarpClusters(BinaryNode* nodes, std::uint32_t* clusters)
      : nodes_(nodes), clusters_(clusters) {}

  /// The lower half of the warp reads the left child's list, the upper half the right one's.
  __device__ void load(const Meeting& meeting) {
    const bool is_left = lane_index() < kHplocGoal;
    const std::uint32_t begin = is_left ? meeting.first : meeting.split + 1;
    const std::uint32_t end = (is_left ? meeting.split : meeting.last) + 1;
    const unsigned place = lane_index() % kHplocGoal;
    cluster_ = place < end - begin ? clusters_[begin + place] : kNoCluster;
    const int source = keep(cluster_ != kNoCluster);
    cluster_ = __shfl_sync(kFullWarp, cluster_, source);
    node_ = is_used() ? load_node(nodes_ + waiting_slot(cluster_)) : BinaryNode{};
    __syncwarp();  // what a lane has read another one writes
  }

  __device__ void merge_until(int goal, int radius) {
    while (size_ > goal) merge_mutual_pairs(find_nearest(radius));
  }

  __device__ void store(const Meeting& meeting) const {
    if (int(lane_index()) >= most_clusters(meeting.count())) return;
    clusters_[meeting.first + lane_index()] = is_used() ? cluster_ : kNoCluster;
    if (is_used()) store_node(nodes_ + waiting_slot(cluster_), node_);
  }

  /// What is left at the end.
  __device__ void store_root() const {
    if (lane_index() == 0) store_node(nodes_ + kRoot, node_);
    if (lane_index() == 1) store_node(nodes_ + kRoot + 1, {});
  }

 private:
  __device__ bool is_used() const { return int(lane_index()) < size_; }

  /// Counts the lanes whose cluster is kept and says from which of them this lane takes its next.
  __device__ int keep(bool is_kept) {
    const unsigned kept = __ballot_sync(kFullWarp, is_kept);
    size_ = __popc(kept);
    return lane_of_bit(kept, lane_index());
  }

  /// The first key of this lane's pairs. The lower lane of a pair finds the key and hands up the
  /// area; the lanes that stand in it the upper one knows.
  __device__ std::uint64_t find_nearest(int radius) const {
    const int lane = int(lane_index());
    std::uint64_t nearest = kNoMerge;
    for (int distance = 1; distance <= std::min(radius, size_ - 1); ++distance) {
      const Aabb merged = merge_with_lane_above(node_.box(), unsigned(distance));
      const std::uint64_t above = merge_key(merged, merged, lane, lane + distance);
      const auto area = __shfl_up_sync(kFullWarp, std::uint32_t(above >> 32), unsigned(distance));
      const std::uint64_t below = std::uint64_t(area) << 32 | unsigned((lane - distance) ^ lane);
      if (lane + distance < size_) nearest = std::min(nearest, above);
      if (lane >= distance) nearest = std::min(nearest, below);
    }
    return is_used() ? nearest : kNoMerge;
  }

  __device__ void merge_mutual_pairs(std::uint64_t nearest) {
    const int lane = int(lane_index());
    const int partner = is_used() ? lane_of_partner(lane, nearest) : lane;
    const bool is_mutual = __shfl_sync(kFullWarp, nearest, partner) == nearest && partner != lane;
    const BinaryNode upper = node_of_lane(node_, partner);
    const std::uint32_t upper_cluster = __shfl_sync(kFullWarp, cluster_, partner);
    if (is_mutual && lane < partner) node_ = merge_clusters(node_, upper, upper_cluster, nodes_);
    const int source = keep(is_used() && !(is_mutual && partner < lane));
    node_ = node_of_lane(node_, source);
    cluster_ = __shfl_sync(kFullWarp, cluster_, source);
  }

  BinaryNode* nodes_;
  std::uint32_t* clusters_;
  BinaryNode node_;
  std::uint32_t cluster_;
  int size_;  // the same in all lanes
};

}  // namespace treelet::cuda
