#pragma once

#include <algorithm>
#include <cstdint>

#include <treelet/core/carver.h>
#include <treelet/core/stream.h>
#include <treelet/tree/bottom_up.h>
#include <treelet/tree/device_tree.h>

namespace treelet::cuda {

struct DeviceCutCounts {
  std::uint32_t subtrees;
  std::uint32_t top;
  std::uint32_t top_depth;  ///< levels of top
};

/// A tree cut as by cut_tree on the host (tree/bottom_up.h), in device memory. Both lists are
/// breadth first, so they depend on the tree alone.
struct DeviceCut {
  std::uint32_t* subtrees = nullptr;  ///< roots below the cut
  std::uint32_t* top = nullptr;       ///< internal nodes above it, by depth, root first
  std::uint32_t* top_ends = nullptr;  ///< depth d is [top_ends[d], top_ends[d + 1]) of top
  DeviceCutCounts* counts = nullptr;
};

/// Nodes above the cut at most. A chain has as many, and no tree has more: the lowest of t such
/// nodes holds over 4096 references, and each of the t - 1 others joins one at least to them.
constexpr std::uint32_t max_top_nodes(std::uint32_t references) {
  return references - std::min(references, kSubtreeReferences);
}

/// Room for the cut of any tree: 12 bytes a reference, of which bushy trees touch 12 in a thousand.
DeviceCut carve_cut(Carver& carver, std::uint32_t capacity);

/// Enqueues it. Kernels over the subtrees, whose number only the device knows, are launched with a
/// fixed number of blocks that loop (for_each_subtree of tree/subtree_levels.cuh).
void cut_tree(const DeviceTree& tree, const DeviceCut& cut, Stream stream);

/// Blocks to launch for a loop over subtrees. A balanced tree has between 1 and 2 subtrees in 4096
/// references, a Morton order's about 2; blocks too many end at once.
constexpr unsigned subtree_blocks(std::uint32_t capacity) { return capacity / 1024 + 1; }

}  // namespace treelet::cuda
