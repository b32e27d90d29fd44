#pragma once

#include <cstdint>

#include <treelet/tree/device_cut.h>
#include <treelet/core/launch.cuh>

// The nodes above the cut, level by level, by one block. All its threads call the functions below;
// they begin with what all have written before a __syncthreads, and end with one.

namespace treelet::cuda {

/// Calls visit(slot) for the nodes of one level above the cut, a thread a node.
template <class Visit>
__device__ void visit_top_level(const DeviceCut& cut, std::uint32_t level, Visit&& visit) {
  const std::uint32_t end = cut.top_ends[level + 1];
  for (std::uint32_t i = cut.top_ends[level] + threadIdx.x; i < end; i += blockDim.x) {
    visit(cut.top[i]);
  }
  __syncthreads();
}

/// Calls visit(slot) for each node above the cut after those below it.
template <class Visit>
__device__ void visit_top_bottom_up(const DeviceCut& cut, Visit visit) {
  for (std::uint32_t level = cut.counts->top_depth; level-- > 0;) {
    visit_top_level(cut, level, visit);
  }
}

/// Calls visit(slot) for each node above the cut before those below it.
template <class Visit>
__device__ void visit_top_top_down(const DeviceCut& cut, Visit visit) {
  for (std::uint32_t level = 0; level < cut.counts->top_depth; ++level) {
    visit_top_level(cut, level, visit);
  }
}

}  // namespace treelet::cuda
