#include <treelet/query/intersect.h>

#include <stdexcept>
#include <string>

#include <treelet/core/parallel.h>
#include <treelet/traverse/tracer.h>

namespace treelet {
namespace {

constexpr std::size_t kRaysPerTask = 512;

void check_room(std::size_t answers, const RayBatch& rays) {
  if (answers >= rays.size) return;
  throw std::invalid_argument("there is room for " + std::to_string(answers) + " answers to " +
                              std::to_string(rays.size) + " rays");
}

/// Calls trace(tracer, ray index) for each ray of the batch.
template <class Layout, class Trace>
void trace_batch(const Layout& bvh, const RayBatch& rays, Trace&& trace) {
  parallel_for_ranges(rays.size, kRaysPerTask, [&](std::size_t begin, std::size_t end) {
    Tracer<Layout> tracer(bvh);
    for (std::size_t i = begin; i < end; ++i) trace(tracer, i);
  });
}

}  // namespace

template <class Layout>
Hit intersect(const Layout& bvh, const Ray& ray) {
  return Tracer<Layout>(bvh).closest(ray);
}

template <class Layout>
bool is_occluded(const Layout& bvh, const Ray& ray) {
  return Tracer<Layout>(bvh).any(ray);
}

template <class Layout>
void intersect(const Layout& bvh, const RayBatch& rays, std::span<Hit> hits) {
  check_room(hits.size(), rays);
  trace_batch(bvh, rays, [&](auto& tracer, std::size_t i) { hits[i] = tracer.closest(rays[i]); });
}

template <class Layout>
void intersect(const Layout& bvh, const RayBatch& rays, const HitArrays& hits) {
  trace_batch(bvh, rays,
              [&](auto& tracer, std::size_t i) { hits.set(i, tracer.closest(rays[i])); });
}

template <class Layout>
void find_occluded(const Layout& bvh, const RayBatch& rays, std::span<bool> occluded) {
  check_room(occluded.size(), rays);
  trace_batch(bvh, rays, [&](auto& tracer, std::size_t i) { occluded[i] = tracer.any(rays[i]); });
}

template <class Layout>
void count_work(const Layout& bvh, const RayBatch& rays, std::span<Work> work) {
  check_room(work.size(), rays);
  trace_batch(bvh, rays, [&](auto& tracer, std::size_t i) { work[i] = tracer.work(rays[i]); });
}

#define TREELET_INSTANTIATE(Layout)                                             \
  template Hit intersect(const Layout&, const Ray&);                            \
  template bool is_occluded(const Layout&, const Ray&);                         \
  template void intersect(const Layout&, const RayBatch&, std::span<Hit>);      \
  template void intersect(const Layout&, const RayBatch&, const HitArrays&);    \
  template void find_occluded(const Layout&, const RayBatch&, std::span<bool>); \
  template void count_work(const Layout&, const RayBatch&, std::span<Work>);
TREELET_INSTANTIATE(Bvh2)
TREELET_INSTANTIATE(Bvh8)
#undef TREELET_INSTANTIATE

}  // namespace treelet
