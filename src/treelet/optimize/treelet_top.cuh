#pragma once

#include <cstdint>

#include <treelet/optimize/treelet.h>
#include <treelet/core/launch.cuh>
#include <treelet/tree/breadth_first.cuh>

// Treelet roots above the cut: one block lists them, then warps climb from those without a listed
// child. Of the warps that come up to a node the last one goes on, so none waits for another.

namespace treelet::cuda {

/// Lists the nodes of at least min_count references and returns how many. One block calls.
__device__ inline std::uint32_t list_top_roots(const DeviceTree& tree, std::uint32_t min_count,
                                               const TopRoots& roots,
                                               BreadthFirstScratch& scratch) {
  const auto write_links = [&](std::uint32_t place, const BinaryNode&,
                               const ListedChildren& children) {
    roots.waits[place] = children.count() == 0 ? 0 : 1 + children.count();
    if (children.left) roots.parents[children.left_place()] = place;
    if (children.right) roots.parents[children.right_place()] = place;
  };
  return walk_breadth_first(
      tree.nodes, kRoot, roots.slots, scratch,
      [&](const BinaryNode& node) { return node.count >= min_count; }, write_links,
      [](std::uint32_t) {});
}

/// Whether this warp is the last to come up from a child. If so, it sees what the warps before it
/// have written.
__device__ inline bool arrives_last(std::uint32_t* waits) {
  __syncwarp();
  std::uint32_t before = 0;
  if (lane_index() == 0) {
    before = __nv_atomic_fetch_sub(waits, 1u, __NV_ATOMIC_ACQ_REL, __NV_THREAD_SCOPE_DEVICE);
  }
  before = __shfl_sync(kFullWarp, before, 0);
  __syncwarp();  // shuffles order no memory
  return before == 2;
}

/// Calls visit(slot) for a root at this place and for those above it that wait for no other.
template <class Visit>
__device__ void climb_from(const TopRoots& roots, std::uint32_t place, Visit&& visit) {
  for (bool goes_on = true; goes_on;) {
    visit(roots.slots[place]);
    if (place == 0) return;
    place = roots.parents[place];
    goes_on = arrives_last(&roots.waits[place]);
  }
}

/// Calls visit(slot) for each root after those below it, a warp a node. Used once: it takes the
/// waits apart.
template <class Visit>
__device__ void climb_top(const TopRoots& roots, Visit visit) {
  const std::uint32_t count = *roots.count, warps = gridDim.x * (blockDim.x / kWarpSize);
  for (std::uint32_t place = warp_index(); place < count; place += warps) {
    // Atomic, since others may be counting down: but never from 0 or to 0.
    const std::uint32_t waits =
        __nv_atomic_load_n(&roots.waits[place], __NV_ATOMIC_RELAXED, __NV_THREAD_SCOPE_DEVICE);
    if (__any_sync(kFullWarp, waits == 0)) climb_from(roots, place, visit);
  }
}

}  // namespace treelet::cuda
