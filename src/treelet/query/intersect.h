#pragma once

#include <span>

#include <treelet/layout/bvh2.h>
#include <treelet/query/ray_batch.h>
#include <treelet/traverse/visitors.h>

namespace treelet {

/// Closest hit of one ray.
Hit intersect(const Bvh2& bvh, const Ray& ray);

/// Whether one ray hits anything in [t_min, t_max].
bool is_occluded(const Bvh2& bvh, const Ray& ray);

// Batches run on all threads; the answers do not depend on how many. Outputs hold one value a ray.

/// Hits as four arrays.
struct HitArrays {
  float* t;
  std::int32_t* face;
  float *u, *v;
};

void intersect(const Bvh2& bvh, const RayBatch& rays, std::span<Hit> hits);
void intersect(const Bvh2& bvh, const RayBatch& rays, const HitArrays& hits);
void find_occluded(const Bvh2& bvh, const RayBatch& rays, std::span<bool> occluded);

/// What finding each ray's closest hit takes.
void count_work(const Bvh2& bvh, const RayBatch& rays, std::span<Work> work);

}  // namespace treelet
