#include <treelet/query/ray_order.h>

#include <treelet/core/parallel.h>
#include <treelet/primitive/radix_sort.h>
#include <treelet/query/ray_order_steps.h>

namespace treelet {

Array<std::uint32_t> order_rays(const Aabb& bounds, const RayBatch& rays) {
  constexpr std::size_t kGrain = 1 << 14;
  const RayGrid grid = make_ray_grid(bounds);
  Array<SortEntry> entries(rays.size);
  parallel_for(rays.size, kGrain,
               [&](std::size_t i) { entries[i] = {ray_key(grid, rays[i]), std::uint32_t(i)}; });
  radix_sort(entries);
  Array<std::uint32_t> order(rays.size);
  parallel_for(rays.size, kGrain, [&](std::size_t i) { order[i] = entries[i].value; });
  return order;
}

}  // namespace treelet
