#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
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

/// Takes twice the memory of the answer at most, and that of the hits of a few rays a thread.
template <class Layout>
AllHits intersect_all(const Layout& bvh, const RayBatch& rays, const AllHitsOptions& options = {});

/// Consecutive rays and their hits.
struct HitChunk {
  std::size_t first_ray;
  AllHits hits;
};

/// Shows all hits of the batch in chunks, in order, of at most `max_hits` hits each; a single ray
/// that has more is a chunk of its own. Rays are counted first, so that memory is bounded whatever
/// they hit. The order of the batch itself must be the given one.
template <class Layout>
void stream_hits(const Layout& bvh, const RayBatch& rays, std::size_t max_hits,
                 const AllHitsOptions& options, const std::function<void(HitChunk&&)>& show);

}  // namespace treelet
