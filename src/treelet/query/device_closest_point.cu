#include <treelet/query/device_closest_point.h>

#include <treelet/query/closest_point_steps.h>
#include <treelet/query/each_item.cuh>
#include <treelet/query/nearest_search.cuh>

namespace treelet::cuda {
namespace {

template <class Layout>
struct FindClosest {
  Layout bvh;
  DevicePointBatch points;
  ClosestPointArrays answers;

  __device__ void operator()(std::size_t i, std::size_t, WaitingChild* stack,
                             std::size_t entries) const {
    const LayoutSize size = bvh.summary->size;
    const bool fits = nearest_stack_entries<Layout>(size.depth) <= entries;
    const Vec3 point = points.points[i];
    const float radius = points.radius(i);
    const bool asks = fits && size.nodes > 0 && point_steps::has_answer(point, radius);
    point_steps::put(answers, i, asks ? find(point, radius, stack) : ClosestPoint{});
  }

 private:
  __device__ ClosestPoint find(Vec3 point, float radius, WaitingChild* stack) const {
    const NearestQuery query{point, point_steps::largest_square(radius)};
    const Nearest nearest = DeviceNearestSearch<Layout>(bvh, stack).find(query);
    if (!point_steps::is_within(nearest, radius)) return {};
    const typename Layout::Item* const items = bvh.items;
    return point_steps::describe(point, nearest, triangle_at(items, nearest.position));
  }
};

}  // namespace

template <class Layout>
void closest_point(const Layout& bvh, std::size_t depth, const DevicePointBatch& points,
                   const ClosestPointArrays& answers, Stream stream) {
  const std::size_t entries = nearest_stack_entries<Layout>(depth);
  const bool is_deep = entries > kLocalStackEntries;
  const Grid grid = threads_for(points.size, is_deep ? entries * sizeof(WaitingChild) : 0);
  launch_each_item<WaitingChild>(stream, grid, points.size, entries,
                                 FindClosest<Layout>{bvh, points, answers});
}

#define TREELET_INSTANTIATE(Layout)                                                \
  template void closest_point(const Layout&, std::size_t, const DevicePointBatch&, \
                              const ClosestPointArrays&, Stream);
TREELET_INSTANTIATE(DeviceBvh2)
TREELET_INSTANTIATE(DeviceBvh8)
TREELET_INSTANTIATE(DeviceCwbvh)
#undef TREELET_INSTANTIATE

}  // namespace treelet::cuda
