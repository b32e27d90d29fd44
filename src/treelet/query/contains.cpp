#include <treelet/query/contains.h>

#include <treelet/core/parallel.h>
#include <treelet/query/closest_point.h>
#include <treelet/query/contains_steps.h>
#include <treelet/query/hit_counts.h>

namespace treelet {
namespace {

constexpr std::size_t kGrain = 1 << 14;

}  // namespace

template <class Layout>
void contains(const Layout& bvh, const PointBatch& points, bool* answers) {
  const PointOrder order(points);
  RayBatch rays;
  rays.size = points.size;
  rays.origins = points.points;
  rays.directions = {&kContainsDirection, 0};
  rays.order = order.data();
  Array<std::int64_t> counts(points.size);
  count_hits(bvh, rays, counts);
  parallel_for(points.size, kGrain, [&](std::size_t i) { answers[i] = counts[i] % 2 != 0; });
}

template <class Layout>
void signed_distance(const Layout& bvh, const PointBatch& points, float* answers) {
  Array<bool> inside(points.size);
  contains(bvh, points, inside.data());
  closest_point(bvh, points, {.distance = answers});
  parallel_for(points.size, kGrain, [&](std::size_t i) {
    if (inside[i] && answers[i] > 0.0f) answers[i] = -answers[i];
  });
}

#define TREELET_INSTANTIATE(Layout)                                \
  template void contains(const Layout&, const PointBatch&, bool*); \
  template void signed_distance(const Layout&, const PointBatch&, float*);
TREELET_INSTANTIATE(Bvh2)
TREELET_INSTANTIATE(Bvh8)
TREELET_INSTANTIATE(Cwbvh)
#undef TREELET_INSTANTIATE

}  // namespace treelet
