#pragma once

#include <cstddef>
#include <cstdint>

#include <treelet/core/stream.h>
#include <treelet/layout/device_layout.h>
#include <treelet/query/device_rays.h>
#include <treelet/query/intersect.h>
#include <treelet/traverse/visitors.h>

namespace treelet::cuda {

/// Work as two arrays in device memory.
struct WorkArrays {
  std::uint32_t *nodes, *triangles;

  /// The work of the rays from one on.
  WorkArrays from(std::size_t ray) const { return {nodes + ray, triangles + ray}; }
};

// The answers are the CPU's, bit for bit (query/intersect.h); outputs are in device memory. `depth`
// is the layout's. Enqueued on the stream; nothing waits.

template <class Layout>
void intersect(const Layout& bvh, std::size_t depth, const DeviceRayBatch& rays,
               const HitArrays& hits, Stream stream);
template <class Layout>
void find_occluded(const Layout& bvh, std::size_t depth, const DeviceRayBatch& rays, bool* occluded,
                   Stream stream);
/// What finding each ray's closest hit takes (traverse/visitors.h). Boxes are tested in another
/// arithmetic and children visited in another order than on the CPU, so the counts differ.
template <class Layout>
void count_work(const Layout& bvh, std::size_t depth, const DeviceRayBatch& rays,
                const WorkArrays& work, Stream stream);

}  // namespace treelet::cuda
