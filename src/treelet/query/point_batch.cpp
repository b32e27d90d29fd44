#include <treelet/query/point_batch.h>

#include <treelet/core/parallel.h>
#include <treelet/mesh/mesh.h>
#include <treelet/primitive/morton.h>
#include <treelet/primitive/radix_sort.h>

namespace treelet {
namespace {

constexpr std::size_t kGrain = 1 << 14;

/// Halved, so that extents of the grid do not overflow.
Vec3 halved(Vec3 point) { return point * 0.5f; }

Aabb finite_bounds(const PointBatch& points) {
  const auto bounds_of = [&](std::size_t begin, std::size_t end) {
    Aabb box = Aabb::empty();
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3 point = points.points[i];
      if (is_finite(point)) box = merge(box, halved(point));
    }
    return box;
  };
  return parallel_reduce(points.size, kGrain, Aabb::empty(), bounds_of,
                         [](const Aabb& a, const Aabb& b) { return merge(a, b); });
}

}  // namespace

Array<std::uint32_t> order_points(const PointBatch& points) {
  const MortonGrid grid = make_morton_grid(finite_bounds(points));
  Array<SortEntry> entries(points.size);
  parallel_for(points.size, kGrain, [&](std::size_t i) {
    const Vec3 point = points.points[i];
    const std::uint64_t code = is_finite(point) ? morton_code(grid, point) : 0;
    entries[i] = {code, std::uint32_t(i)};
  });
  radix_sort(entries);
  Array<std::uint32_t> order(points.size);
  parallel_for(points.size, kGrain, [&](std::size_t i) { order[i] = entries[i].value; });
  return order;
}

}  // namespace treelet
