#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <treelet/core/parallel.h>
#include <treelet/core/ray.h>
#include <treelet/query/ray_batch.h>
#include <treelet/traverse/enumerate.h>
#include <treelet/traverse/hit_sink.h>

// From crossings in the order in which a traversal finds them to rows, one a ray: sorted, and each
// face once.

namespace treelet {

inline Hit as_row_item(const RayHit& hit) { return {hit.t, hit.face, hit.u, hit.v}; }
inline std::int32_t as_row_item(const RayFace& hit) { return hit.face; }

/// Sorts a ray's hits by (t, face), and drops all but one of those that a split triangle has in
/// several leaves. Returns how many are left.
std::size_t sort_row(std::span<Hit> row);
/// The same for faces alone.
std::size_t sort_row(std::span<std::int32_t> row);

/// Rows of records whose rays are numbered from zero.
template <class Record>
class HitRows {
 public:
  using Item = decltype(as_row_item(Record{}));

  void assign(std::span<const Record> records, std::size_t rays) {
    ends_.assign(rays, 0);
    for (const Record& record : records) ++ends_[record.ray];
    std::size_t end = 0;
    for (std::size_t& row : ends_) end += std::exchange(row, end);
    items_.resize(records.size());
    for (const Record& record : records) items_[ends_[record.ray]++] = as_row_item(record);
  }

  /// To be asked for once.
  std::span<const Item> sorted(std::size_t ray) {
    const std::size_t begin = ray == 0 ? 0 : ends_[ray - 1];
    const std::span<Item> row(items_.data() + begin, ends_[ray] - begin);
    return row.first(sort_row(row));
  }

 private:
  std::vector<std::size_t> ends_;
  std::vector<Item> items_;
};

/// Rays that a thread traces at a time.
inline constexpr std::size_t kRaysPerRowTask = 1024;

/// Calls show(k, row) for the rays k in [begin, end) of the batch's order; at most kRaysPerRowTask.
template <class Record, class Layout, class Show>
void show_rows(const Layout& bvh, const RayBatch& rays, std::size_t begin, std::size_t end,
               Show&& show) {
  Ray part[kRaysPerRowTask];
  const std::size_t count = end - begin;
  for (std::size_t k = 0; k < count; ++k) part[k] = rays[rays.ray_of(begin + k)];
  Enumerator<Layout> enumerator(bvh, count, rays.filter);
  HitSink<Record> sink;
  HitRows<Record> rows;
  for (std::size_t done = 0; done < count;) {
    sink.clear();
    const std::span<const Ray> left(part + done, count - done);
    const std::size_t traced = enumerator.run(left, sink);
    rows.assign(sink.records(), traced);
    for (std::size_t k = 0; k < traced; ++k) show(begin + done + k, rows.sorted(k));
    done += traced;
  }
}

/// As show_rows of hits, of which the first `limit` of each ray alone are shown.
template <class Layout, class Show>
void show_first_rows(const Layout& bvh, const RayBatch& rays, std::size_t begin, std::size_t end,
                     std::size_t limit, Show&& show) {
  show_rows<RayHit>(bvh, rays, begin, end, [&](std::size_t k, std::span<const Hit> row) {
    show(k, row.first(std::min(row.size(), limit)));
  });
}

/// Traces no farther than it must where few are wanted.
template <class Show>
void show_first_rows(const Bvh8& bvh, const RayBatch& rays, std::size_t begin, std::size_t end,
                     std::size_t limit, Show&& show) {
  if (limit > FirstHits::kMost) {
    return show_first_rows<Bvh8, Show>(bvh, rays, begin, end, limit, std::forward<Show>(show));
  }
  std::vector<Ray> part(end - begin);
  for (std::size_t k = begin; k < end; ++k) part[k - begin] = rays[rays.ray_of(k)];
  std::vector<FirstHits> found(end - begin);
  FirstHitsFinder(bvh, part.size(), rays.filter).run(part, std::uint32_t(limit), found);
  for (std::size_t k = begin; k < end; ++k) {
    const FirstHits& row = found[k - begin];
    show(k, std::span<const Hit>(row.hits, row.count));
  }
}

}  // namespace treelet
