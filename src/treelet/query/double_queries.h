#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include <treelet/core/array.h>
#include <treelet/core/double_ray.h>
#include <treelet/layout/double_bvh8.h>
#include <treelet/query/ray_batch.h>

// The queries of query/intersect.h, query/hit_counts.h and query/all_hits.h in doubles, on all
// threads.

namespace treelet {

/// RayBatch in doubles.
struct DoubleRayBatch {
  std::size_t size = 0;
  PerRay<DoubleVec3> origins, directions;
  PerRay<double> t_min{&kDefaults.t_min, 0}, t_max{&kDefaults.t_max, 0};

  DoubleRayBatch() = default;
  DoubleRayBatch(std::span<const DoubleRay> rays);  // NOLINT: an array of rays is a batch

  DoubleRay operator[](std::size_t i) const {
    return {origins[i], directions[i], t_min[i], t_max[i]};
  }

 private:
  static constexpr DoubleRay kDefaults{};
};

/// AllHits in doubles.
struct DoubleAllHits {
  Array<std::int64_t> offsets;
  Array<double> t;
  Array<std::int32_t> face;
  Array<double> u, v;
};

// Each span must have room for an answer a ray; std::invalid_argument otherwise.
void intersect(const DoubleBvh8& bvh, const DoubleRayBatch& rays, std::span<DoubleHit> hits);
void find_occluded(const DoubleBvh8& bvh, const DoubleRayBatch& rays, std::span<bool> occluded);
void count_hits(const DoubleBvh8& bvh, const DoubleRayBatch& rays, std::span<std::int64_t> counts);
/// The first `limit` of each ray.
DoubleAllHits intersect_all(const DoubleBvh8& bvh, const DoubleRayBatch& rays,
                            std::size_t limit = std::numeric_limits<std::size_t>::max());

}  // namespace treelet
