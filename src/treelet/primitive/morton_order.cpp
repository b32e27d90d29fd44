#include <treelet/primitive/morton_order.h>

#include <treelet/core/parallel.h>
#include <treelet/core/stage.h>
#include <treelet/primitive/morton.h>
#include <treelet/primitive/morton_codes.h>
#include <treelet/primitive/radix_sort.h>

namespace treelet {
namespace {

constexpr std::size_t kGrain = 1 << 14;

Array<SortEntry> compute_morton_codes(const References& references) {
  const Stage stage{"compute Morton codes"};
  const MortonGrid grid = make_morton_grid(references.bounds);
  const MortonAxes axes(grid);
  const MortonKernel kernel = morton_kernel(best_isa());
  Array<SortEntry> entries(references.size());
  parallel_for_ranges(references.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    if (kernel) return kernel(axes, references.items.data(), begin, end, entries.data());
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3 centroid = doubled_centroid(references.items[i].box());
      entries[i] = {morton_code(grid, centroid), std::uint32_t(i)};
    }
  });
  return entries;
}

}  // namespace

MortonOrder sort_along_morton_curve(const References& references) {
  Array<SortEntry> entries = compute_morton_codes(references);
  const Stage stage{"sort Morton codes"};
  radix_sort(entries);
  MortonOrder order{Array<std::uint64_t>(entries.size()), Array<std::uint32_t>(entries.size())};
  parallel_for(entries.size(), kGrain, [&](std::size_t i) {
    order.codes[i] = entries[i].key;
    order.references[i] = entries[i].value;
  });
  return order;
}

}  // namespace treelet
