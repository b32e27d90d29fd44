#include <treelet/query/device_all_hits.h>

#include <treelet/query/count_crossings.cuh>

namespace treelet::cuda {
namespace {

struct PutCount {
  std::int64_t* counts;
  __device__ void operator()(std::size_t i, std::uint32_t count) const { counts[i] = count; }
};

/// Where the rows of rays lie.
struct Rows {
  const std::int64_t* offsets;
  HitArrays hits;

  __device__ HitRow operator[](std::size_t i) const {
    const std::int64_t begin = offsets[i];
    return {{hits.t + begin, hits.face + begin, hits.u + begin, hits.v + begin}};
  }
  /// Hits that fit the row of ray i.
  __device__ std::uint32_t room(std::size_t i) const {
    return std::uint32_t(offsets[i + 1] - offsets[i]);
  }
};

struct FillRows {
  using Visitor = FillRow;
  Rows rows;

  __device__ Visitor start(std::size_t i, const Ray& ray) const {
    return {ray, rows[i], rows.room(i)};
  }
  __device__ void operator()(std::size_t, const Visitor& visitor) const { sort(visitor.row); }
};

/// Copies rows from windows, which hold each face once.
template <class Layout>
struct CopyRows {
  Layout bvh;
  DeviceRayBatch rays;
  WindowMemory::View windows;
  Rows rows;

  __device__ void operator()(std::size_t k, std::size_t thread,
                             typename DeviceStack<Layout>::Entry* stack,
                             std::size_t entries) const {
    const std::size_t i = rays.ray_of(k);
    HitRow row = rows[i];
    const std::uint32_t room = rows.room(i);
    if (room == 0) return;
    show_windows(bvh, rays[i], Stack<Layout>{stack, entries}, windows.of(thread),
                 [&](const HitRow& found) {
                   for (std::uint32_t n = 0; n < found.size && row.size < room; ++n) {
                     row.push(found[n]);
                   }
                   return row.size < room;
                 });
  }
};

}  // namespace

template <class Layout>
void count_hits(const Layout& bvh, const TreeFacts& facts, const DeviceRayBatch& rays,
                std::uint32_t limit, std::int64_t* counts, Stream stream) {
  count_crossings(bvh, facts, rays, limit, PutCount{counts}, stream);
}

template <class Layout>
void list_hits(const Layout& bvh, const TreeFacts& facts, const DeviceRayBatch& rays,
               const std::int64_t* offsets, const HitArrays& hits, Stream stream) {
  if (rays.size == 0) return;
  const Rows rows{offsets, hits};
  if (!facts.repeats_faces) {
    return trace_batch(bvh, facts.depth, rays, FillRows{rows}, stream);
  }
  trace_in_windows<Layout>(facts.depth, rays, stream, [&](WindowMemory::View windows) {
    return CopyRows<Layout>{bvh, rays, windows, rows};
  });
}

#define TREELET_INSTANTIATE(Layout)                                                               \
  template void count_hits(const Layout&, const TreeFacts&, const DeviceRayBatch&, std::uint32_t, \
                           std::int64_t*, Stream);                                                \
  template void list_hits(const Layout&, const TreeFacts&, const DeviceRayBatch&,                 \
                          const std::int64_t*, const HitArrays&, Stream);
TREELET_INSTANTIATE(DeviceBvh2)
TREELET_INSTANTIATE(DeviceBvh8)
TREELET_INSTANTIATE(DeviceCwbvh)
#undef TREELET_INSTANTIATE

}  // namespace treelet::cuda
