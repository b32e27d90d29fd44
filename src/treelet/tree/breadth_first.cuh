#pragma once

#include <cstdint>

#include <treelet/tree/binary_tree.h>
#include <treelet/core/launch.cuh>

// The top of a tree or of a subtree, listed breadth first by one block without atomics: the list is
// the same however the threads are scheduled.

namespace treelet::cuda {

/// Which children of a listed node are listed too, and where.
struct ListedChildren {
  bool left, right;
  std::uint32_t place;  ///< of the first of them; where neither is listed, of the next to come

  __device__ std::uint32_t count() const { return std::uint32_t(left) + std::uint32_t(right); }
  __device__ std::uint32_t left_place() const { return place; }
  __device__ std::uint32_t right_place() const { return place + std::uint32_t(left); }
};

/// Scratch of a walk, in shared memory.
struct BreadthFirstScratch {
  std::uint32_t warp_counts[kWarpSize];  // a block has 32 warps at most
};

/// Numbers the listed children of a block's threads from `first` on, in thread order. `first`
/// becomes the number behind the last. The whole block calls; ends with __syncthreads.
__device__ inline ListedChildren number_children(bool left, bool right, std::uint32_t& first,
                                                 BreadthFirstScratch& scratch) {
  const unsigned warp = threadIdx.x / kWarpSize, warps = blockDim.x / kWarpSize;
  const unsigned lefts = __ballot_sync(kFullWarp, left), rights = __ballot_sync(kFullWarp, right);
  const unsigned lanes_before = (1u << lane_index()) - 1;
  if (lane_index() == 0) {
    scratch.warp_counts[warp] = std::uint32_t(__popc(lefts) + __popc(rights));
  }
  __syncthreads();
  std::uint32_t place =
      first + std::uint32_t(__popc(lefts & lanes_before) + __popc(rights & lanes_before));
  for (unsigned other = 0; other < warps; ++other) {
    const std::uint32_t count = scratch.warp_counts[other];
    if (other < warp) place += count;
    first += count;
  }
  __syncthreads();
  return {left, right, place};
}

/// Puts the slots of the internal nodes below and with `root` that keep(node) accepts into `list`,
/// breadth first; returns how many. What is below a node that is not kept may not be kept. Calls
/// expand(place, node, children) for each node of the list, by any thread, and end_level(end) for
/// each level, by all. The whole block of full warps calls; ends with __syncthreads.
template <class Keep, class Expand, class EndLevel>
__device__ std::uint32_t walk_breadth_first(const BinaryNode* nodes, std::uint32_t root,
                                            std::uint32_t* list, BreadthFirstScratch& scratch,
                                            Keep keep, Expand expand, EndLevel end_level) {
  const auto is_listed = [&](const BinaryNode& node) { return !node.is_leaf() && keep(node); };
  std::uint32_t begin = 0, end = is_listed(nodes[root]) ? 1 : 0;
  if (threadIdx.x == 0 && end > 0) list[0] = root;
  __syncthreads();
  while (begin < end) {
    end_level(end);
    std::uint32_t next = end;
    for (std::uint32_t first = begin; first < end; first += blockDim.x) {
      const std::uint32_t place = first + threadIdx.x;
      const bool is_node = place < end;
      const BinaryNode& node = nodes[is_node ? list[place] : root];
      const bool left = is_node && is_listed(nodes[node.left()]);
      const bool right = is_node && is_listed(nodes[node.right()]);
      const ListedChildren children = number_children(left, right, next, scratch);
      if (left) list[children.left_place()] = node.left();
      if (right) list[children.right_place()] = node.right();
      if (is_node) expand(place, node, children);
    }
    begin = end;
    end = next;
    __syncthreads();
  }
  return end;
}

}  // namespace treelet::cuda
