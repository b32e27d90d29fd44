#pragma once

#include <cstdint>
#include <span>

#include <treelet/layout/bvh2.h>
#include <treelet/layout/bvh8.h>
#include <treelet/layout/cwbvh.h>
#include <treelet/query/ray_batch.h>

namespace treelet {

// How often rays cross the mesh with t in [t_min, t_max], both included. A crossing belongs to
// exactly one of two triangles that the surface passes through at an edge, and to one of all at a
// vertex: traverse/crossing.h has the rule. Each face counts once, also where a split one lies in
// several leaves.
//
// For a mesh that is closed (every edge, by positions, in an even number of triangles), limits
// [0, inf] and any direction, the count is even for an origin outside and odd for one inside,
// without exception and at any scale. From an origin on the surface the ray starts just before it:
// the parity is that of the side that the direction comes from. Triangles seen edge-on count zero,
// a silhouette zero or two.
//
// Rays that are not is_traceable (traverse/is_traceable.h) count 0. For the layouts Bvh2, Bvh8 and
// Cwbvh, with the same answers for any number of threads.

template <class Layout>
std::int64_t count_hits(const Layout& bvh, const Ray& ray);

/// One count a ray; a shorter span is a std::invalid_argument. Takes the memory of the hits of a
/// few rays a thread.
template <class Layout>
void count_hits(const Layout& bvh, const RayBatch& rays, std::span<std::int64_t> counts);

}  // namespace treelet
