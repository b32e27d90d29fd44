#include <treelet/query/closest_point.h>

#include <treelet/core/parallel.h>
#include <treelet/layout/child_view.h>
#include <treelet/query/closest_point_steps.h>
#include <treelet/query/nearest_search.h>

namespace treelet {
namespace {

constexpr std::size_t kPointsPerTask = 1024;

template <class Layout>
ClosestPoint describe(const Layout& bvh, Vec3 point, float max_distance, const Nearest& nearest) {
  if (!point_steps::is_within(nearest, max_distance)) return {};
  return point_steps::describe(point, nearest, triangle_at(bvh, nearest.position));
}

/// Finds the nearest triangles of the k-th points that can have one.
template <class Layout>
class Task {
 public:
  explicit Task(const Layout& bvh) : bvh_(bvh), searcher_(bvh) {}

  void run(const PointBatch& points, std::size_t begin, std::size_t end, const PointOrder& order,
           const ClosestPointArrays& answers) {
    std::size_t count = 0;
    for (std::size_t k = begin; k < end; ++k) {
      const std::size_t i = order(k);
      const Vec3 point = points.points[i];
      const float max_distance = points.radii[i];
      if (point_steps::has_answer(point, max_distance)) {
        numbers_[count] = i;
        queries_[count++] = {point, point_steps::largest_square(max_distance)};
      } else {
        point_steps::put(answers, i, {});
      }
    }
    searcher_.run({queries_, count}, found_);
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t i = numbers_[k];
      point_steps::put(answers, i, describe(bvh_, queries_[k].point, points.radii[i], found_[k]));
    }
  }

 private:
  const Layout& bvh_;
  NearestSearcher<Layout> searcher_;
  std::size_t numbers_[kPointsPerTask];
  NearestQuery queries_[kPointsPerTask];
  Nearest found_[kPointsPerTask];
};

}  // namespace

template <class Layout>
ClosestPoint closest_point(const Layout& bvh, Vec3 point, float max_distance) {
  if (!point_steps::has_answer(point, max_distance)) return {};
  const NearestQuery query{point, point_steps::largest_square(max_distance)};
  Nearest nearest;
  NearestSearcher<Layout>(bvh).run({&query, 1}, &nearest);
  return describe(bvh, point, max_distance, nearest);
}

template <class Layout>
void closest_point(const Layout& bvh, const PointBatch& points, const ClosestPointArrays& answers) {
  const PointOrder order(points);
  parallel_for_ranges(points.size, kPointsPerTask, [&](std::size_t begin, std::size_t end) {
    Task<Layout>(bvh).run(points, begin, end, order, answers);
  });
}

#define TREELET_INSTANTIATE(Layout)                                \
  template ClosestPoint closest_point(const Layout&, Vec3, float); \
  template void closest_point(const Layout&, const PointBatch&, const ClosestPointArrays&);
TREELET_INSTANTIATE(Bvh2)
TREELET_INSTANTIATE(Bvh8)
TREELET_INSTANTIATE(Cwbvh)
#undef TREELET_INSTANTIATE

}  // namespace treelet
