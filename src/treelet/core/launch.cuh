#pragma once

#include <algorithm>
#include <cstdint>
#include <type_traits>

#include <cuda_runtime.h>

#include <treelet/core/stream.h>
#include <treelet/core/cuda_check.cuh>

namespace treelet::cuda {

constexpr int kWarpSize = 32;
constexpr unsigned kFullWarp = 0xffffffff;

/// How many blocks of how many threads.
struct Grid {
  unsigned blocks;
  unsigned threads;
};

/// A thread for each of `count` items.
inline Grid thread_each(std::size_t count, unsigned threads = 256) {
  return {unsigned((count + threads - 1) / threads), threads};
}
/// A warp for each of `count` items.
inline Grid warp_each(std::size_t count, unsigned threads = 256) {
  return thread_each(count * kWarpSize, threads);
}

/// Enqueues a kernel; nothing to do is no launch.
template <class... Parameters, class... Arguments>
void launch(Stream stream, Grid grid, void (*kernel)(Parameters...), Arguments&&... arguments) {
  if (grid.blocks == 0) return;
  cudaLaunchConfig_t config{};
  config.gridDim = dim3(grid.blocks);
  config.blockDim = dim3(grid.threads);
  config.stream = stream;
  check(cudaLaunchKernelEx(&config, kernel, Parameters(arguments)...), "launch a kernel");
}

/// Index of this thread in a grid of one dimension.
__device__ inline std::uint32_t thread_index() { return blockIdx.x * blockDim.x + threadIdx.x; }
__device__ inline std::uint32_t warp_index() { return thread_index() / kWarpSize; }
__device__ inline unsigned lane_index() { return threadIdx.x % kWarpSize; }

}  // namespace treelet::cuda
