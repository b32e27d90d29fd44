#include <treelet/query/intersect.h>

#include <algorithm>
#include <stdexcept>
#include <string>

#include <treelet/core/parallel.h>
#include <treelet/traverse/tracer.h>

namespace treelet {
namespace {

constexpr std::size_t kRaysPerTask = 1024;

void check_room(std::size_t answers, const RayBatch& rays) {
  if (answers >= rays.size) return;
  throw std::invalid_argument("there is room for " + std::to_string(answers) + " answers to " +
                              std::to_string(rays.size) + " rays");
}

/// Moves the numbers of active rays to the front, in their order, and returns how many there are.
std::size_t put_active_first(const RayBatch& rays, std::span<std::size_t> numbers) {
  if (rays.active.first == nullptr) return numbers.size();
  const auto is_active = [&](std::size_t ray) { return rays.is_active(ray); };
  const auto end = std::stable_partition(numbers.begin(), numbers.end(), is_active);
  return std::size_t(end - numbers.begin());
}

/// Calls trace(tracer, rays, answers) for parts of the batch, then put(ray, answer) for each ray.
template <class Answer, class Layout, class Trace, class Put>
void trace_batch(const Layout& bvh, const RayBatch& rays, Trace&& trace, Put&& put) {
  parallel_for_ranges(rays.size, kRaysPerTask, [&](std::size_t begin, std::size_t end) {
    const std::size_t count = end - begin;
    std::size_t numbers[kRaysPerTask];
    Ray part[kRaysPerTask];
    Answer answers[kRaysPerTask];
    rays.list_rays(begin, end, numbers);
    const std::size_t active = put_active_first(rays, std::span(numbers, count));
    for (std::size_t k = 0; k < active; ++k) part[k] = rays[numbers[k]];
    Tracer<Layout> tracer(bvh, active, rays.filter);
    trace(tracer, std::span<const Ray>(part, active), answers);
    for (std::size_t k = 0; k < active; ++k) put(numbers[k], answers[k]);
    for (std::size_t k = active; k < count; ++k) put(numbers[k], Answer{});
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
  trace_batch<Hit>(
      bvh, rays, [](auto& tracer, auto part, Hit* found) { tracer.closest(part, found); },
      [&](std::size_t ray, const Hit& hit) { hits[ray] = hit; });
}

template <class Layout>
void intersect(const Layout& bvh, const RayBatch& rays, const HitArrays& hits) {
  trace_batch<Hit>(
      bvh, rays, [](auto& tracer, auto part, Hit* found) { tracer.closest(part, found); },
      [&](std::size_t ray, const Hit& hit) { hits.set(ray, hit); });
}

template <class Layout>
void find_occluded(const Layout& bvh, const RayBatch& rays, std::span<bool> occluded) {
  check_room(occluded.size(), rays);
  trace_batch<bool>(
      bvh, rays, [](auto& tracer, auto part, bool* found) { tracer.any(part, found); },
      [&](std::size_t ray, bool found) { occluded[ray] = found; });
}

template <class Layout>
void count_work(const Layout& bvh, const RayBatch& rays, std::span<Work> work) {
  check_room(work.size(), rays);
  trace_batch<Work>(
      bvh, rays, [](auto& tracer, auto part, Work* counts) { tracer.work(part, counts); },
      [&](std::size_t ray, const Work& counts) { work[ray] = counts; });
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
TREELET_INSTANTIATE(Cwbvh)
#undef TREELET_INSTANTIATE

}  // namespace treelet
