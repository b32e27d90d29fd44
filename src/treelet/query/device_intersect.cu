#include <treelet/query/device_intersect.h>

#include <treelet/query/device_trace.cuh>

namespace treelet::cuda {
namespace {

/// A visitor that knows its ray alone.
template <class VisitorOf>
struct FromRay {
  using Visitor = VisitorOf;
  __device__ Visitor start(std::size_t, const Ray& ray) const { return Visitor(ray); }
};

// What a ray's visitor leaves behind.
struct WriteHit : FromRay<ClosestHit<>> {
  HitArrays hits;
  __device__ void operator()(std::size_t i, const Visitor& visitor) const {
    hits.set(i, visitor.hit);
  }
};
struct WriteOccluded : FromRay<AnyHit> {
  bool* occluded;
  __device__ void operator()(std::size_t i, const Visitor& visitor) const {
    occluded[i] = visitor.found;
  }
};
struct WriteWork : FromRay<ClosestHit<Counting>> {
  WorkArrays work;
  __device__ void operator()(std::size_t i, const Visitor& visitor) const {
    work.nodes[i] = visitor.work.nodes;
    work.triangles[i] = visitor.work.triangles;
  }
};

}  // namespace

template <class Layout>
void intersect(const Layout& bvh, std::size_t depth, const DeviceRayBatch& rays,
               const HitArrays& hits, Stream stream) {
  trace_batch(bvh, depth, rays, WriteHit{{}, hits}, stream);
}

template <class Layout>
void find_occluded(const Layout& bvh, std::size_t depth, const DeviceRayBatch& rays, bool* occluded,
                   Stream stream) {
  trace_batch(bvh, depth, rays, WriteOccluded{{}, occluded}, stream);
}

template <class Layout>
void count_work(const Layout& bvh, std::size_t depth, const DeviceRayBatch& rays,
                const WorkArrays& work, Stream stream) {
  trace_batch(bvh, depth, rays, WriteWork{{}, work}, stream);
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
