#include <treelet/query/device_contains.h>

#include <limits>

#include <treelet/query/contains_steps.h>
#include <treelet/query/device_closest_point.h>
#include <treelet/query/count_crossings.cuh>

namespace treelet::cuda {
namespace {

constexpr std::uint32_t kNoLimit = std::numeric_limits<std::uint32_t>::max();

struct PutInside {
  bool* inside;
  __device__ void operator()(std::size_t i, std::uint32_t count) const {
    inside[i] = count % 2 != 0;
  }
};

/// Makes distances of points inside negative.
struct NegateInside {
  float* distance;
  __device__ void operator()(std::size_t i, std::uint32_t count) const {
    if (count % 2 != 0 && distance[i] > 0.0f) distance[i] = -distance[i];
  }
};

__global__ void write_direction(Vec3* to, Vec3 direction) { *to = direction; }

/// Calls put(i, crossings of a ray from point i).
template <class Layout, class Put>
void count_from(const Layout& bvh, const TreeFacts& facts, const DevicePointBatch& points,
                const Put& put, Stream stream) {
  if (points.size == 0) return;
  DeviceArray<Vec3> direction(1, stream);
  launch(stream, Grid{1, 1}, write_direction, direction.data(), kContainsDirection);
  DeviceRayBatch rays;
  rays.size = points.size;
  rays.origins = points.points;
  rays.directions = {direction.data(), 0};
  count_crossings(bvh, facts, rays, kNoLimit, put, stream);
}

}  // namespace

template <class Layout>
void contains(const Layout& bvh, const TreeFacts& facts, const DevicePointBatch& points,
              bool* answers, Stream stream) {
  count_from(bvh, facts, points, PutInside{answers}, stream);
}

template <class Layout>
void signed_distance(const Layout& bvh, const TreeFacts& facts, const DevicePointBatch& points,
                     float* answers, Stream stream) {
  closest_point(bvh, facts.depth, points, {.distance = answers}, stream);
  count_from(bvh, facts, points, NegateInside{answers}, stream);
}

#define TREELET_INSTANTIATE(Layout)                                                                \
  template void contains(const Layout&, const TreeFacts&, const DevicePointBatch&, bool*, Stream); \
  template void signed_distance(const Layout&, const TreeFacts&, const DevicePointBatch&, float*,  \
                                Stream);
TREELET_INSTANTIATE(DeviceBvh2)
TREELET_INSTANTIATE(DeviceBvh8)
TREELET_INSTANTIATE(DeviceCwbvh)
#undef TREELET_INSTANTIATE

}  // namespace treelet::cuda
