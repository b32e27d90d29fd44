#include <treelet/query/device_intersect.h>

#include <algorithm>

#include <treelet/core/device_array.h>
#include <treelet/traverse/is_traceable.h>
#include <treelet/core/launch.cuh>
#include <treelet/traverse/traverse_bvh2.cuh>
#include <treelet/traverse/traverse_bvh8.cuh>
#include <treelet/traverse/traverse_cwbvh.cuh>

namespace treelet::cuda {
namespace {

// A thread a ray. Differs from [AilaLaine2009], whose threads persist and fetch rays: blocks of
// four warps leave little idle at their ends, and nothing has to be counted.
constexpr unsigned kThreads = 128;
constexpr unsigned kBlocksPerProcessor = 8;  // leaves a thread 64 registers

// What a ray's visitor leaves behind.
struct WriteHit {
  using Visitor = ClosestHit<>;
  HitArrays hits;
  __device__ void operator()(std::size_t i, const Visitor& visitor) const {
    hits.set(i, visitor.hit);
  }
};
struct WriteOccluded {
  using Visitor = AnyHit;
  bool* occluded;
  __device__ void operator()(std::size_t i, const Visitor& visitor) const {
    occluded[i] = visitor.found;
  }
};
struct WriteWork {
  using Visitor = ClosestHit<Counting>;
  WorkArrays work;
  __device__ void operator()(std::size_t i, const Visitor& visitor) const {
    work.nodes[i] = visitor.work.nodes;
    work.triangles[i] = visitor.work.triangles;
  }
};

/// A thread's stack.
template <class Layout>
struct Stack {
  typename DeviceStack<Layout>::Entry* entries;
  std::size_t size;
};

/// A tree that was rebuilt and not checked may be deeper than the host knows: then it is empty.
template <class Layout, class Write>
__device__ void trace(const Layout& bvh, const DeviceRayBatch& rays, std::size_t thread,
                      const Stack<Layout>& stack, const Write& write) {
  const std::size_t i = rays.ray_of(thread);
  const Ray ray = rays[i];
  RayMemory<typename Write::Visitor> memory(ray);
  const LayoutSummary& summary = *bvh.summary;
  const bool fits = DeviceStack<Layout>::entries(summary.size.depth) <= stack.size;
  if (fits && summary.size.nodes > 0 && is_traceable(ray)) {
    memory.set_up(ray, summary.bounds);
    traverse(bvh, memory, stack.entries);
  }
  write(i, memory.visitor);
}

template <class Layout, class Write>
__global__ void __launch_bounds__(kThreads, kBlocksPerProcessor)
    trace_rays(Layout bvh, DeviceRayBatch rays, std::size_t first, Write write) {
  const std::size_t i = first + thread_index();
  if (i >= rays.size) return;
  typename DeviceStack<Layout>::Entry stack[kLocalStackEntries];
  trace(bvh, rays, i, Stack<Layout>{stack, kLocalStackEntries}, write);
}

/// For trees too deep for the local stack: each thread goes through many rays with a stack of its
/// own in global memory.
template <class Layout, class Write>
__global__ void __launch_bounds__(kThreads, kBlocksPerProcessor)
    trace_rays_deep(Layout bvh, DeviceRayBatch rays, typename DeviceStack<Layout>::Entry* stacks,
                    std::size_t entries, Write write) {
  auto* const stack = stacks + thread_index() * entries;
  const std::size_t threads = std::size_t(gridDim.x) * blockDim.x;
  for (std::size_t i = thread_index(); i < rays.size; i += threads) {
    trace(bvh, rays, i, Stack<Layout>{stack, entries}, write);
  }
}

template <class Layout, class Write>
void trace_batch_deep(const Layout& bvh, std::size_t entries, const DeviceRayBatch& rays,
                      const Write& write, Stream stream) {
  using Entry = typename DeviceStack<Layout>::Entry;
  constexpr std::size_t kStackBytes = std::size_t{1} << 28;
  const std::size_t threads =
      std::clamp<std::size_t>(kStackBytes / (entries * sizeof(Entry)), kThreads, 1 << 16);
  const Grid grid = thread_each(std::min(threads, rays.size), kThreads);
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
    launch(stream, thread_each(count, kThreads), trace_rays<Layout, Write>, bvh, rays, first,
           write);
  }
}

}  // namespace

template <class Layout>
void intersect(const Layout& bvh, std::size_t depth, const DeviceRayBatch& rays,
               const HitArrays& hits, Stream stream) {
  trace_batch(bvh, depth, rays, WriteHit{hits}, stream);
}

template <class Layout>
void find_occluded(const Layout& bvh, std::size_t depth, const DeviceRayBatch& rays, bool* occluded,
                   Stream stream) {
  trace_batch(bvh, depth, rays, WriteOccluded{occluded}, stream);
}

template <class Layout>
void count_work(const Layout& bvh, std::size_t depth, const DeviceRayBatch& rays,
                const WorkArrays& work, Stream stream) {
  trace_batch(bvh, depth, rays, WriteWork{work}, stream);
}

#define TREELET_INSTANTIATE(Layout)                                                              \
  template void intersect(const Layout&, std::size_t, const DeviceRayBatch&, const HitArrays&,   \
                          Stream);                                                               \
  template void find_occluded(const Layout&, std::size_t, const DeviceRayBatch&, bool*, Stream); \
  template void count_work(const Layout&, std::size_t, const DeviceRayBatch&, const WorkArrays&, \
                           Stream);
TREELET_INSTANTIATE(DeviceBvh2)
TREELET_INSTANTIATE(DeviceBvh8)
TREELET_INSTANTIATE(DeviceCwbvh)
#undef TREELET_INSTANTIATE

}  // namespace treelet::cuda
