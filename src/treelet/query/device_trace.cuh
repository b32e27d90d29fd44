#pragma once

#include <algorithm>
#include <cstddef>

#include <treelet/core/device_array.h>
#include <treelet/query/device_rays.h>
#include <treelet/traverse/device_stack.h>
#include <treelet/traverse/is_traceable.h>
#include <treelet/core/launch.cuh>
#include <treelet/traverse/traverse_bvh2.cuh>
#include <treelet/traverse/traverse_bvh8.cuh>
#include <treelet/traverse/traverse_cwbvh.cuh>

// How a batch of rays is traced, whatever is asked. `Write` says what: write.start(i, ray) is the
// visitor of ray i, of type Write::Visitor, and write(i, visitor) takes what that has found.

namespace treelet::cuda {

// A thread a ray. Differs from [AilaLaine2009], whose threads persist and fetch rays: blocks of
// four warps leave little idle at their ends, and nothing has to be counted.
constexpr unsigned kTraceThreads = 128;
constexpr unsigned kTraceBlocks = 8;  // a processor: leaves a thread 64 registers

/// A thread's stack.
template <class Layout>
struct Stack {
  typename DeviceStack<Layout>::Entry* entries;
  std::size_t size;
};

/// Shows the visitor what the ray meets. A tree that was rebuilt and not checked may be deeper than
/// the host knows: then it is empty.
template <class Layout, class Visitor>
__device__ void trace(const Layout& bvh, const Ray& ray, const Stack<Layout>& stack,
                      RayMemory<Visitor>& memory) {
  const LayoutSummary& summary = *bvh.summary;
  const bool fits = DeviceStack<Layout>::entries(summary.size.depth) <= stack.size;
  if (!fits || summary.size.nodes == 0 || !is_traceable(ray)) return;
  memory.set_up(ray, summary.bounds);
  traverse(bvh, memory, stack.entries);
}

template <class Layout, class Write>
__device__ void answer_ray(const Layout& bvh, const DeviceRayBatch& rays, std::size_t thread,
                           const Stack<Layout>& stack, const Write& write) {
  const std::size_t i = rays.ray_of(thread);
  const Ray ray = rays[i];
  RayMemory<typename Write::Visitor> memory(write.start(i, ray));
  trace(bvh, ray, stack, memory);
  write(i, memory.visitor);
}

template <class Layout, class Write>
__global__ void __launch_bounds__(kTraceThreads, kTraceBlocks)
    trace_rays(Layout bvh, DeviceRayBatch rays, std::size_t first, Write write) {
  const std::size_t i = first + thread_index();
  if (i >= rays.size) return;
  typename DeviceStack<Layout>::Entry stack[kLocalStackEntries];
  answer_ray(bvh, rays, i, Stack<Layout>{stack, kLocalStackEntries}, write);
}

/// For trees too deep for the local stack: each thread goes through many rays with a stack of its
/// own in global memory.
template <class Layout, class Write>
__global__ void __launch_bounds__(kTraceThreads, kTraceBlocks)
    trace_rays_deep(Layout bvh, DeviceRayBatch rays, typename DeviceStack<Layout>::Entry* stacks,
                    std::size_t entries, Write write) {
  auto* const stack = stacks + thread_index() * entries;
  const std::size_t threads = std::size_t(gridDim.x) * blockDim.x;
  for (std::size_t i = thread_index(); i < rays.size; i += threads) {
    answer_ray(bvh, rays, i, Stack<Layout>{stack, entries}, write);
  }
}

/// Threads whose stacks in global memory take 256 MiB at most.
inline std::size_t count_deep_threads(std::size_t stack_bytes) {
  constexpr std::size_t kStackBytes = std::size_t{1} << 28;
  return std::clamp<std::size_t>(kStackBytes / stack_bytes, kTraceThreads, 1 << 16);
}

template <class Layout, class Write>
void trace_batch_deep(const Layout& bvh, std::size_t entries, const DeviceRayBatch& rays,
                      const Write& write, Stream stream) {
  using Entry = typename DeviceStack<Layout>::Entry;
  const std::size_t threads = count_deep_threads(entries * sizeof(Entry));
  const Grid grid = thread_each(std::min(threads, rays.size), kTraceThreads);
  DeviceArray<Entry> stacks(std::size_t(grid.blocks) * grid.threads * entries, stream);
  launch(stream, grid, trace_rays_deep<Layout, Write>, bvh, rays, stacks.data(), entries, write);
}

template <class Layout, class Write>
void trace_batch(const Layout& bvh, std::size_t depth, const DeviceRayBatch& rays,
                 const Write& write, Stream stream) {
  const std::size_t entries = DeviceStack<Layout>::entries(depth);
  if (entries > kLocalStackEntries) return trace_batch_deep(bvh, entries, rays, write, stream);
  constexpr std::size_t kRaysPerLaunch = std::size_t{1} << 30;  // thread_index() has 32 bits
  for (std::size_t first = 0; first < rays.size; first += kRaysPerLaunch) {
    const std::size_t count = std::min(kRaysPerLaunch, rays.size - first);
    launch(stream, thread_each(count, kTraceThreads), trace_rays<Layout, Write>, bvh, rays, first,
           write);
  }
}

}  // namespace treelet::cuda
