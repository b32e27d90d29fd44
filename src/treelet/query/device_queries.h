#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <treelet/query/device_all_hits.h>
#include <treelet/query/device_intersect.h>
#include <treelet/query/stream_rays.h>

// The queries of rays as values, so that batches can be cut into parts and be sent over in chunks
// without saying each time what is asked. A query writes where it was made to; query(bvh, depth,
// rays, first, stream) enqueues the answers to rays whose places begin at `first`.

namespace treelet::cuda {

struct ClosestHitQuery {
  HitArrays hits;

  std::array<AnswerArray, 4> answers() const {
    return {{{hits.t, sizeof(*hits.t)},
             {hits.face, sizeof(*hits.face)},
             {hits.u, sizeof(*hits.u)},
             {hits.v, sizeof(*hits.v)}}};
  }
  /// The same query with answers in other arrays, in the order of answers().
  static ClosestHitQuery into(std::span<void* const> arrays) {
    return {{static_cast<float*>(arrays[0]), static_cast<std::int32_t*>(arrays[1]),
             static_cast<float*>(arrays[2]), static_cast<float*>(arrays[3])}};
  }
  template <class Layout>
  void operator()(const Layout& bvh, std::size_t depth, const DeviceRayBatch& rays,
                  std::size_t first, Stream stream) const {
    intersect(bvh, depth, rays, hits.from(first), stream);
  }
};

struct AnyHitQuery {
  bool* occluded;

  std::array<AnswerArray, 1> answers() const { return {{{occluded, sizeof(*occluded)}}}; }
  static AnyHitQuery into(std::span<void* const> arrays) { return {static_cast<bool*>(arrays[0])}; }
  template <class Layout>
  void operator()(const Layout& bvh, std::size_t depth, const DeviceRayBatch& rays,
                  std::size_t first, Stream stream) const {
    find_occluded(bvh, depth, rays, occluded + first, stream);
  }
};

struct WorkQuery {
  WorkArrays work;

  std::array<AnswerArray, 2> answers() const {
    return {{{work.nodes, sizeof(*work.nodes)}, {work.triangles, sizeof(*work.triangles)}}};
  }
  static WorkQuery into(std::span<void* const> arrays) {
    return {{static_cast<std::uint32_t*>(arrays[0]), static_cast<std::uint32_t*>(arrays[1])}};
  }
  template <class Layout>
  void operator()(const Layout& bvh, std::size_t depth, const DeviceRayBatch& rays,
                  std::size_t first, Stream stream) const {
    count_work(bvh, depth, rays, work.from(first), stream);
  }
};

/// What it needs to know of the tree besides stays with the query.
struct HitCountQuery {
  std::int64_t* counts;
  std::uint32_t limit;
  TreeFacts facts;

  std::array<AnswerArray, 1> answers() const { return {{{counts, sizeof(*counts)}}}; }
  HitCountQuery into(std::span<void* const> arrays) const {
    return {static_cast<std::int64_t*>(arrays[0]), limit, facts};
  }
  template <class Layout>
  void operator()(const Layout& bvh, std::size_t, const DeviceRayBatch& rays, std::size_t first,
                  Stream stream) const {
    count_hits(bvh, facts, rays, limit, counts + first, stream);
  }
};

/// Writes to where the offsets say.
struct HitListQuery {
  const std::int64_t* offsets;
  HitArrays hits;
  TreeFacts facts;

  template <class Layout>
  void operator()(const Layout& bvh, std::size_t, const DeviceRayBatch& rays, std::size_t first,
                  Stream stream) const {
    list_hits(bvh, facts, rays, offsets + first, hits, stream);
  }
};

/// Enqueues a query of rays in device memory in the order asked for.
template <class Layout, class Query>
void trace_rays_in_order(const Layout& bvh, std::size_t depth, const DeviceRayBatch& rays,
                         RayOrder order, const Query& query, Stream stream) {
  trace_in_order(order, &bvh.summary->bounds, rays, stream,
                 [&](const DeviceRayBatch& part, std::size_t first) {
                   query(bvh, depth, part, first, stream);
                 });
}

}  // namespace treelet::cuda
