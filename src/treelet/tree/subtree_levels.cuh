#pragma once

#include <cstdint>

#include <treelet/tree/binary_tree.h>
#include <treelet/tree/bottom_up.h>
#include <treelet/tree/device_cut.h>
#include <treelet/tree/device_tree.h>
#include <treelet/core/launch.cuh>
#include <treelet/tree/breadth_first.cuh>

namespace treelet::cuda {

/// Internal nodes of one subtree below the cut, breadth first, in the shared memory of the block
/// that works on it: 24.2 KiB. Level d is [ends[d - 1], ends[d]) of slots, level 0 the root alone.
struct SubtreeLevels {
  /// A full binary tree has one internal node less than leaves, and no more levels than internal
  /// nodes: a chain has as many.
  static constexpr std::uint32_t kNodes = kSubtreeReferences - 1;

  std::uint32_t slots[kNodes];
  std::uint16_t ends[kNodes];
  int depth;  ///< levels
  int count;  ///< nodes
  BreadthFirstScratch scratch;

  __device__ std::uint32_t begin(int level) const { return level == 0 ? 0 : ends[level - 1]; }
  __device__ std::uint32_t end(int level) const { return ends[level]; }
};
static_assert(SubtreeLevels::kNodes <= UINT16_MAX);

// A whole block of full warps calls the functions below; they begin with what all its threads have
// written before a __syncthreads, and end with one.

/// Lists the internal nodes that keep(node) accepts. What is below a node that is not kept may not
/// be kept, as for node.count >= min_count.
template <class Keep>
__device__ void list_levels(const BinaryNode* nodes, std::uint32_t root, Keep keep,
                            SubtreeLevels& levels) {
  int depth = 0;
  const std::uint32_t count = walk_breadth_first(
      nodes, root, levels.slots, levels.scratch, keep,
      [](std::uint32_t, const BinaryNode&, const ListedChildren&) {},
      [&](std::uint32_t end) {
        if (threadIdx.x == 0) levels.ends[depth] = std::uint16_t(end);
        ++depth;
      });
  if (threadIdx.x == 0) {
    levels.depth = depth;
    levels.count = int(count);
  }
  __syncthreads();
}

/// What list_levels takes to list all internal nodes.
struct KeepAll {
  __device__ bool operator()(const BinaryNode&) const { return true; }
};

/// Calls work(root) for each subtree below the cut, a block a subtree.
template <class Work>
__device__ void for_each_subtree(const DeviceCut& cut, Work work) {
  for (std::uint32_t s = blockIdx.x; s < cut.counts->subtrees; s += gridDim.x) {
    work(cut.subtrees[s]);
  }
}

/// Lists each subtree below the cut, a block a subtree, and calls work() meanwhile.
template <class Keep, class Work>
__device__ void for_each_subtree(const DeviceTree& tree, const DeviceCut& cut, Keep keep,
                                 SubtreeLevels& levels, Work work) {
  for_each_subtree(cut, [&](std::uint32_t root) {
    list_levels(tree.nodes, root, keep, levels);
    work();
  });
}

/// Calls visit(slot) for the nodes of one level, by thread `worker` of so many that share them.
template <class Visit>
__device__ void visit_level(const SubtreeLevels& levels, int level, unsigned worker,
                            unsigned workers, Visit&& visit) {
  const std::uint32_t end = levels.end(level);
  for (std::uint32_t i = levels.begin(level) + worker; i < end; i += workers) {
    visit(levels.slots[i]);
  }
}

/// Calls visit(slot) for each node after all those below it, a thread a node.
template <class Visit>
__device__ void visit_bottom_up(const SubtreeLevels& levels, Visit visit) {
  for (int level = levels.depth - 1; level >= 0; --level) {
    visit_level(levels, level, threadIdx.x, blockDim.x, visit);
    __syncthreads();
  }
}

/// Calls visit(slot) for each node before those below it, a thread a node.
template <class Visit>
__device__ void visit_top_down(const SubtreeLevels& levels, Visit visit) {
  for (int level = 0; level < levels.depth; ++level) {
    visit_level(levels, level, threadIdx.x, blockDim.x, visit);
    __syncthreads();
  }
}

/// As visit_bottom_up, a warp a node: all its lanes call visit(slot).
template <class Visit>
__device__ void visit_bottom_up_by_warps(const SubtreeLevels& levels, Visit visit) {
  for (int level = levels.depth - 1; level >= 0; --level) {
    visit_level(levels, level, threadIdx.x / kWarpSize, blockDim.x / kWarpSize, visit);
    __syncthreads();
  }
}

}  // namespace treelet::cuda
