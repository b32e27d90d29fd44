#include <treelet/query/hit_counts.h>

#include <stdexcept>
#include <string>

#include <treelet/query/hit_rows.h>

namespace treelet {

template <class Layout>
std::int64_t count_hits(const Layout& bvh, const Ray& ray) {
  std::int64_t count = 0;
  show_rows<RayFace>(bvh, std::span(&ray, 1), 0, 1,
                     [&](std::size_t, auto row) { count = std::int64_t(row.size()); });
  return count;
}

template <class Layout>
void count_hits(const Layout& bvh, const RayBatch& rays, std::span<std::int64_t> counts) {
  if (counts.size() < rays.size) {
    throw std::invalid_argument("there is room for " + std::to_string(counts.size()) +
                                " counts of " + std::to_string(rays.size) + " rays");
  }
  parallel_for_ranges(rays.size, kRaysPerRowTask, [&](std::size_t begin, std::size_t end) {
    show_rows<RayFace>(bvh, rays, begin, end, [&](std::size_t k, auto row) {
      counts[rays.ray_of(k)] = std::int64_t(row.size());
    });
  });
}

#define TREELET_INSTANTIATE(Layout)                            \
  template std::int64_t count_hits(const Layout&, const Ray&); \
  template void count_hits(const Layout&, const RayBatch&, std::span<std::int64_t>);
TREELET_INSTANTIATE(Bvh2)
TREELET_INSTANTIATE(Bvh8)
TREELET_INSTANTIATE(Cwbvh)
#undef TREELET_INSTANTIATE

}  // namespace treelet
