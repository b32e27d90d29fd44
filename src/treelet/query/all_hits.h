#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <treelet/core/array.h>
#include <treelet/layout/bvh2.h>
#include <treelet/layout/bvh8.h>
#include <treelet/layout/cwbvh.h>
#include <treelet/query/ray_batch.h>
#include <treelet/query/ray_order.h>

namespace treelet {

/// The hits of many rays, one ray's after the other's: those of ray i lie in
/// [offsets[i], offsets[i + 1]).
struct AllHits {
  Array<std::int64_t> offsets;
  Array<float> t;
  Array<std::int32_t> face;
  Array<float> u, v;

  std::size_t ray_count() const { return offsets.size() - 1; }
  std::size_t size() const { return t.size(); }
};

/// Which hits are kept.
struct AllHitsOptions {
  std::size_t limit = std::numeric_limits<std::size_t>::max();  ///< the first so many of each ray
  RayOrder order = RayOrder::given;                             ///< in which rays are traced
};

// Every crossing of each ray with t in [t_min, t_max], as query/hit_counts.h counts them, sorted by
// (t, face). For the layouts Bvh2, Bvh8 and Cwbvh, with the same answers for any number of threads.
// A crossing at a t beyond the largest float has t = inf and belongs to rays whose t_max is
// infinite.

template <class Layout>
std::vector<Hit> intersect_all(const Layout& bvh, const Ray& ray,
                               const AllHitsOptions& options = {});

/// Takes twice the memory of the answer at most, and that of the hits of a few rays a thread. To
/// bound it, count the hits first (query/hit_counts.h), then list parts of the batch.
template <class Layout>
AllHits intersect_all(const Layout& bvh, const RayBatch& rays, const AllHitsOptions& options = {});

}  // namespace treelet
