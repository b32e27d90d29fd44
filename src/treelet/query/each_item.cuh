#pragma once

#include <algorithm>
#include <cstddef>

#include <treelet/core/device_array.h>
#include <treelet/traverse/device_stack.h>
#include <treelet/core/launch.cuh>

// Threads that go through many items each, with memory of their own.

namespace treelet::cuda {

constexpr unsigned kItemThreads = 128;  // of a block

/// A stack of `size` entries a thread, one thread's after the other's; null: in local memory.
template <class Entry>
struct ThreadStacks {
  Entry* entries = nullptr;
  std::size_t size = kLocalStackEntries;
};

/// Calls body(item, thread, stack, entries of the stack).
template <class Entry, class Body>
__global__ void __launch_bounds__(kItemThreads)
    do_each_item(std::size_t count, ThreadStacks<Entry> stacks, Body body) {
  Entry local[kLocalStackEntries];
  const std::size_t thread = thread_index();
  Entry* const stack = stacks.entries == nullptr ? local : stacks.entries + thread * stacks.size;
  const std::size_t threads = std::size_t(gridDim.x) * blockDim.x;
  for (std::size_t i = thread; i < count; i += threads) body(i, thread, stack, stacks.size);
}

/// How many threads go through so many items, with stacks of so many bytes in all memory but local.
inline Grid threads_for(std::size_t count, std::size_t bytes_each) {
  constexpr std::size_t kMostBytes = std::size_t{1} << 28, kMostThreads = std::size_t{1} << 18;
  const std::size_t most = kMostBytes / std::max<std::size_t>(bytes_each, 1);
  const std::size_t threads = std::clamp<std::size_t>(most, kItemThreads, kMostThreads);
  return thread_each(std::min(threads, count), kItemThreads);
}

/// Enqueues body for each item on these threads, with stacks of so many entries.
template <class Entry, class Body>
void launch_each_item(Stream stream, Grid grid, std::size_t count, std::size_t entries,
                      const Body& body) {
  const std::size_t threads = std::size_t(grid.blocks) * grid.threads;
  const bool is_local = entries <= kLocalStackEntries;
  DeviceArray<Entry> memory(is_local ? 0 : threads * entries, stream);
  ThreadStacks<Entry> stacks;
  if (!is_local) stacks = {memory.data(), entries};
  launch(stream, grid, do_each_item<Entry, Body>, count, stacks, body);
}

}  // namespace treelet::cuda
