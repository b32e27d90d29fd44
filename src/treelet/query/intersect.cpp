#include <treelet/query/intersect.h>

#include <treelet/core/parallel.h>
#include <treelet/traverse/traverse_bvh2.h>

namespace treelet {
namespace {

constexpr std::size_t kRaysPerTask = 512;

template <class Visitor>
Visitor trace(const Bvh2& bvh, const Ray& ray, TraversalStack& stack) {
  Visitor visitor(ray);
  traverse(bvh, ray, stack, visitor);
  return visitor;
}

template <class Visitor>
Visitor trace(const Bvh2& bvh, const Ray& ray) {
  TraversalStack stack(bvh.depth);
  return trace<Visitor>(bvh, ray, stack);
}

/// Calls store(ray index, visitor) for each ray of the batch.
template <class Visitor, class Store>
void trace_batch(const Bvh2& bvh, const RayBatch& rays, Store&& store) {
  parallel_for_ranges(rays.size, kRaysPerTask, [&](std::size_t begin, std::size_t end) {
    TraversalStack stack(bvh.depth);
    for (std::size_t i = begin; i < end; ++i) store(i, trace<Visitor>(bvh, rays[i], stack));
  });
}

}  // namespace

Hit intersect(const Bvh2& bvh, const Ray& ray) { return trace<ClosestHit<>>(bvh, ray).hit; }

bool is_occluded(const Bvh2& bvh, const Ray& ray) { return trace<AnyHit>(bvh, ray).found; }

void intersect(const Bvh2& bvh, const RayBatch& rays, std::span<Hit> hits) {
  trace_batch<ClosestHit<>>(bvh, rays,
                            [&](std::size_t i, const auto& visitor) { hits[i] = visitor.hit; });
}

void intersect(const Bvh2& bvh, const RayBatch& rays, const HitArrays& hits) {
  trace_batch<ClosestHit<>>(bvh, rays, [&](std::size_t i, const auto& visitor) {
    hits.t[i] = visitor.hit.t;
    hits.face[i] = visitor.hit.face;
    hits.u[i] = visitor.hit.u;
    hits.v[i] = visitor.hit.v;
  });
}

void find_occluded(const Bvh2& bvh, const RayBatch& rays, std::span<bool> occluded) {
  trace_batch<AnyHit>(bvh, rays,
                      [&](std::size_t i, const auto& visitor) { occluded[i] = visitor.found; });
}

void count_work(const Bvh2& bvh, const RayBatch& rays, std::span<Work> work) {
  trace_batch<ClosestHit<Counting>>(
      bvh, rays, [&](std::size_t i, const auto& visitor) { work[i] = visitor.work; });
}

}  // namespace treelet
