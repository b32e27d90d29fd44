#include <treelet/query/all_hits.h>

#include <algorithm>
#include <utility>

#include <treelet/query/hit_counts.h>
#include <treelet/query/hit_rows.h>

namespace treelet {
namespace {

/// What one task found: its rays, in the order traced, and their rows one after the other.
struct TaskHits {
  std::vector<std::size_t> rays;
  std::vector<Hit> hits;
};

AllHits make_room(Array<std::int64_t>&& offsets) {
  const auto size = std::size_t(offsets[offsets.size() - 1]);
  return {std::move(offsets), Array<float>(size), Array<std::int32_t>(size), Array<float>(size),
          Array<float>(size)};
}

/// Counts, a place late, become offsets.
void add_up(std::span<std::int64_t> counts) {
  for (std::size_t i = 1; i < counts.size(); ++i) counts[i] += counts[i - 1];
}

void copy_rows(const TaskHits& task, AllHits& all) {
  const Hit* hit = task.hits.data();
  for (const std::size_t ray : task.rays) {
    const auto end = std::size_t(all.offsets[ray + 1]);
    for (auto i = std::size_t(all.offsets[ray]); i < end; ++i, ++hit) {
      all.t[i] = hit->t;
      all.face[i] = hit->face;
      all.u[i] = hit->u;
      all.v[i] = hit->v;
    }
  }
}

/// Traces a part of the batch whose first ray is `first`; writes counts to where offsets end.
template <class Layout>
void trace_part(const Layout& bvh, const RayBatch& part, std::size_t first, std::size_t limit,
                std::span<std::int64_t> counts, std::vector<TaskHits>& tasks) {
  const std::size_t first_task = tasks.size();
  tasks.resize(first_task + (part.size + kRaysPerRowTask - 1) / kRaysPerRowTask);
  parallel_for_ranges(part.size, kRaysPerRowTask, [&](std::size_t begin, std::size_t end) {
    TaskHits& task = tasks[first_task + begin / kRaysPerRowTask];
    task.rays.reserve(end - begin);
    show_first_rows(bvh, part, begin, end, limit, [&](std::size_t k, std::span<const Hit> row) {
      const std::size_t ray = first + part.ray_of(k);
      task.rays.push_back(ray);
      task.hits.insert(task.hits.end(), row.begin(), row.end());
      counts[ray + 1] = std::int64_t(row.size());
    });
  });
}

}  // namespace

template <class Layout>
std::vector<Hit> intersect_all(const Layout& bvh, const Ray& ray, const AllHitsOptions& options) {
  std::vector<Hit> hits;
  const RayBatch one(std::span(&ray, 1));
  show_first_rows(bvh, one, 0, 1, options.limit, [&](std::size_t, std::span<const Hit> row) {
    hits.assign(row.begin(), row.end());
  });
  return hits;
}

template <class Layout>
AllHits intersect_all(const Layout& bvh, const RayBatch& rays, const AllHitsOptions& options) {
  Array<std::int64_t> offsets(rays.size + 1);
  offsets[0] = 0;
  std::vector<TaskHits> tasks;
  trace_in_order(options.order, bvh.bounds, rays, [&](const RayBatch& part, std::size_t first) {
    trace_part(bvh, part, first, options.limit, offsets, tasks);
  });
  add_up(offsets);
  AllHits all = make_room(std::move(offsets));
  parallel_for(tasks.size(), 1, [&](std::size_t i) {
    copy_rows(tasks[i], all);
    tasks[i] = {};
  });
  return all;
}

#define TREELET_INSTANTIATE(Layout)                                                          \
  template std::vector<Hit> intersect_all(const Layout&, const Ray&, const AllHitsOptions&); \
  template AllHits intersect_all(const Layout&, const RayBatch&, const AllHitsOptions&);
TREELET_INSTANTIATE(Bvh2)
TREELET_INSTANTIATE(Bvh8)
TREELET_INSTANTIATE(Cwbvh)
#undef TREELET_INSTANTIATE

}  // namespace treelet
