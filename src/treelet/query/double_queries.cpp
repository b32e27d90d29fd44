#include <treelet/query/double_queries.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

#include <treelet/core/parallel.h>
#include <treelet/traverse/traverse_double.h>

namespace treelet {
namespace {

constexpr std::size_t kRaysPerTask = 256;

void check_room(std::size_t answers, const DoubleRayBatch& rays) {
  if (answers >= rays.size) return;
  throw std::invalid_argument("there is room for " + std::to_string(answers) + " answers to " +
                              std::to_string(rays.size) + " rays");
}

/// Calls trace(tracer, ray, number) for all rays.
template <class Trace>
void trace_batch(const DoubleBvh8& bvh, const DoubleRayBatch& rays, Trace&& trace) {
  parallel_for_ranges(rays.size, kRaysPerTask, [&](std::size_t begin, std::size_t end) {
    DoubleRayTracer tracer(bvh);
    for (std::size_t i = begin; i < end; ++i) trace(tracer, rays[i], i);
  });
}

/// The hits of the rays of a task; how many are each ray's, the offsets tell.
using TaskHits = std::vector<DoubleHit>;

/// Lists hits by tasks; writes counts to where offsets end.
std::vector<TaskHits> list_hits(const DoubleBvh8& bvh, const DoubleRayBatch& rays,
                                std::size_t limit, std::span<std::int64_t> offsets) {
  std::vector<TaskHits> tasks((rays.size + kRaysPerTask - 1) / kRaysPerTask);
  parallel_for_ranges(rays.size, kRaysPerTask, [&](std::size_t begin, std::size_t end) {
    DoubleRayTracer tracer(bvh);
    TaskHits& task = tasks[begin / kRaysPerTask];
    std::vector<DoubleHit> row;
    for (std::size_t i = begin; i < end; ++i) {
      tracer.list(rays[i], row);
      row.resize(std::min(row.size(), limit));
      task.insert(task.end(), row.begin(), row.end());
      offsets[i + 1] = std::int64_t(row.size());
    }
  });
  return tasks;
}

void write_hits(const TaskHits& hits, std::size_t first, DoubleAllHits& all) {
  for (std::size_t i = 0; i < hits.size(); ++i) {
    all.t[first + i] = hits[i].t;
    all.face[first + i] = hits[i].face;
    all.u[first + i] = hits[i].u;
    all.v[first + i] = hits[i].v;
  }
}

}  // namespace

DoubleRayBatch::DoubleRayBatch(std::span<const DoubleRay> rays) : size(rays.size()) {
  if (rays.empty()) return;
  origins = {&rays[0].origin, sizeof(DoubleRay)};
  directions = {&rays[0].direction, sizeof(DoubleRay)};
  t_min = {&rays[0].t_min, sizeof(DoubleRay)};
  t_max = {&rays[0].t_max, sizeof(DoubleRay)};
}

void intersect(const DoubleBvh8& bvh, const DoubleRayBatch& rays, std::span<DoubleHit> hits) {
  check_room(hits.size(), rays);
  trace_batch(bvh, rays, [&](DoubleRayTracer& tracer, const DoubleRay& ray, std::size_t i) {
    hits[i] = tracer.closest(ray);
  });
}

void find_occluded(const DoubleBvh8& bvh, const DoubleRayBatch& rays, std::span<bool> occluded) {
  check_room(occluded.size(), rays);
  trace_batch(bvh, rays, [&](DoubleRayTracer& tracer, const DoubleRay& ray, std::size_t i) {
    occluded[i] = tracer.any(ray);
  });
}

void count_hits(const DoubleBvh8& bvh, const DoubleRayBatch& rays, std::span<std::int64_t> counts) {
  check_room(counts.size(), rays);
  trace_batch(bvh, rays, [&](DoubleRayTracer& tracer, const DoubleRay& ray, std::size_t i) {
    counts[i] = tracer.count(ray);
  });
}

DoubleAllHits intersect_all(const DoubleBvh8& bvh, const DoubleRayBatch& rays, std::size_t limit) {
  DoubleAllHits all;
  all.offsets = Array<std::int64_t>(rays.size + 1);
  all.offsets[0] = 0;
  std::vector<TaskHits> tasks = list_hits(bvh, rays, limit, all.offsets);
  for (std::size_t i = 0; i < rays.size; ++i) all.offsets[i + 1] += all.offsets[i];
  const auto size = std::size_t(all.offsets[rays.size]);
  all.t = Array<double>(size);
  all.face = Array<std::int32_t>(size);
  all.u = Array<double>(size);
  all.v = Array<double>(size);
  parallel_for(tasks.size(), 1, [&](std::size_t i) {
    write_hits(tasks[i], std::size_t(all.offsets[i * kRaysPerTask]), all);
    tasks[i] = {};
  });
  return all;
}

}  // namespace treelet
