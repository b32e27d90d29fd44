#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include <treelet/layout/bvh2.h>
#include <treelet/layout/bvh8.h>
#include <treelet/layout/cwbvh.h>
#include <treelet/query/ray_batch.h>
#include <treelet/traverse/visitors.h>

namespace treelet {

/// Hits as four arrays.
struct HitArrays {
  float* t;
  std::int32_t* face;
  float *u, *v;

  TREELET_HD void set(std::size_t ray, const Hit& hit) const {
    t[ray] = hit.t;
    face[ray] = hit.face;
    u[ray] = hit.u;
    v[ray] = hit.v;
  }
  /// The hits of the rays from one on.
  HitArrays from(std::size_t ray) const { return {t + ray, face + ray, u + ray, v + ray}; }
};

// All for the layouts Bvh2, Bvh8 and Cwbvh, with the same answers. Batches run on all threads, and
// the answers do not depend on how many; their outputs hold one value a ray, and a shorter span is
// a std::invalid_argument.

/// Closest hit of one ray.
template <class Layout>
Hit intersect(const Layout& bvh, const Ray& ray);

/// Whether one ray hits anything in [t_min, t_max].
template <class Layout>
bool is_occluded(const Layout& bvh, const Ray& ray);

template <class Layout>
void intersect(const Layout& bvh, const RayBatch& rays, std::span<Hit> hits);
template <class Layout>
void intersect(const Layout& bvh, const RayBatch& rays, const HitArrays& hits);
template <class Layout>
void find_occluded(const Layout& bvh, const RayBatch& rays, std::span<bool> occluded);

/// What finding each ray's closest hit takes.
template <class Layout>
void count_work(const Layout& bvh, const RayBatch& rays, std::span<Work> work);

}  // namespace treelet
