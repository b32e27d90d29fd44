#pragma once

#include <cstddef>
#include <cstdint>

#include <treelet/core/stream.h>
#include <treelet/layout/device_layout.h>
#include <treelet/query/device_rays.h>
#include <treelet/query/intersect.h>

namespace treelet::cuda {

/// What the host knows of a tree.
struct TreeFacts {
  std::size_t depth = 0;
  /// Whether a face may lie in several leaves: then rows are made in bounded memory of their own,
  /// 256 MiB at most, to see that.
  bool repeats_faces = false;
};

// All crossings, and how many: the CPU's, bit for bit (query/all_hits.h). Enqueued on the stream;
// nothing waits.

/// How often each ray crosses the mesh, but no more than `limit`.
template <class Layout>
void count_hits(const Layout& bvh, const TreeFacts& facts, const DeviceRayBatch& rays,
                std::uint32_t limit, std::int64_t* counts, Stream stream);

/// Writes the first hits of ray i, as many as there is room, to [offsets[i], offsets[i + 1]): for
/// offsets from counts under a limit, the hits up to that. They are sorted by (t, face).
template <class Layout>
void list_hits(const Layout& bvh, const TreeFacts& facts, const DeviceRayBatch& rays,
               const std::int64_t* offsets, const HitArrays& hits, Stream stream);

}  // namespace treelet::cuda
