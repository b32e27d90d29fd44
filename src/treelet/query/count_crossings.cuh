#pragma once

#include <cstddef>
#include <cstdint>

#include <treelet/core/device_array.h>
#include <treelet/query/device_all_hits.h>
#include <treelet/query/hit_window.h>
#include <treelet/query/crossing_visitors.cuh>
#include <treelet/query/device_trace.cuh>
#include <treelet/query/each_item.cuh>

// Counts crossings, for whoever wants to know: put(i, count) takes the count of ray i.
//
// Where no face lies in two leaves, they are counted as they are met. Else they are gathered in
// windows (query/hit_window.h).

namespace treelet::cuda {

/// Shows a ray's hits, sorted and each face once, window by window, until take(row) is false.
template <class Layout, class Take>
__device__ void show_windows(const Layout& bvh, const Ray& ray, const Stack<Layout>& stack,
                             HitWindow window, Take&& take) {
  window.begin();
  for (bool goes_on = true; goes_on; window.advance()) {
    Ray rest = ray;
    if (window.t_min() > ray.t_min) rest.t_min = window.t_min();
    RayMemory<GatherCrossings> memory(GatherCrossings(rest, window));
    trace(bvh, rest, stack, memory);
    window = memory.visitor.window;
    goes_on = take(window.finish()) && window.was_cut();
  }
}

/// Windows in device memory, one a thread.
class WindowMemory {
 public:
  static constexpr std::uint32_t kHits = 128;  // of a window
  static constexpr std::size_t kBytes = kHits * sizeof(Hit);

  WindowMemory(const Grid& grid, Stream stream)
      : bytes_(std::size_t(grid.blocks) * grid.threads * kBytes, stream) {}

  /// Where they lie, for kernels.
  struct View {
    std::byte* first;
    __device__ HitWindow of(std::size_t thread) const {
      auto* const floats = reinterpret_cast<float*>(first + thread * kBytes);
      auto* const faces = reinterpret_cast<std::int32_t*>(floats + 3 * kHits);
      return {{floats, faces, floats + kHits, floats + 2 * kHits}, kHits};
    }
  };
  View view() { return {bytes_.data()}; }

 private:
  DeviceArray<std::byte> bytes_;
};

template <class Layout, class Put>
struct CountInWindows {
  Layout bvh;
  DeviceRayBatch rays;
  WindowMemory::View windows;
  std::uint32_t limit;
  Put put;

  __device__ void operator()(std::size_t k, std::size_t thread,
                             typename DeviceStack<Layout>::Entry* stack,
                             std::size_t entries) const {
    const std::size_t i = rays.ray_of(k);
    std::uint32_t count = 0;
    show_windows(bvh, rays[i], Stack<Layout>{stack, entries}, windows.of(thread),
                 [&](const HitRow& row) {
                   count = row.size < limit - count ? count + row.size : limit;
                   return count < limit;
                 });
    put(i, count);
  }
};

/// Counts as they are met.
template <class Put>
struct CountOnTheWay {
  using Visitor = CountCrossings;
  std::uint32_t limit;
  Put put;

  __device__ Visitor start(std::size_t, const Ray& ray) const { return {ray, limit}; }
  __device__ void operator()(std::size_t i, const Visitor& visitor) const { put(i, visitor.count); }
};

/// Calls body for each ray, with a window and a stack a thread, where `make_body` makes the body of
/// the windows.
template <class Layout, class MakeBody>
void trace_in_windows(std::size_t depth, const DeviceRayBatch& rays, Stream stream,
                      MakeBody&& make_body) {
  using Entry = typename DeviceStack<Layout>::Entry;
  const std::size_t entries = DeviceStack<Layout>::entries(depth);
  const std::size_t stack_bytes = entries > kLocalStackEntries ? entries * sizeof(Entry) : 0;
  const Grid grid = threads_for(rays.size, WindowMemory::kBytes + stack_bytes);
  WindowMemory windows(grid, stream);
  launch_each_item<Entry>(stream, grid, rays.size, entries, make_body(windows.view()));
}

template <class Layout, class Put>
void count_crossings(const Layout& bvh, const TreeFacts& facts, const DeviceRayBatch& rays,
                     std::uint32_t limit, const Put& put, Stream stream) {
  if (rays.size == 0) return;
  if (!facts.repeats_faces) {
    return trace_batch(bvh, facts.depth, rays, CountOnTheWay<Put>{limit, put}, stream);
  }
  trace_in_windows<Layout>(facts.depth, rays, stream, [&](WindowMemory::View windows) {
    return CountInWindows<Layout, Put>{bvh, rays, windows, limit, put};
  });
}

}  // namespace treelet::cuda
