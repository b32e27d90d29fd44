#pragma once

#include <treelet/query/point_batch.h>

namespace treelet {

// For the layouts Bvh2, Bvh8 and Cwbvh, with the same answers, on all threads.

/// Whether a closed mesh contains each point: whether a ray from it crosses the mesh an odd number
/// of times. Crossings are counted exactly (query/hit_counts.h), so one ray is enough, whatever
/// edges it meets. Of two solids that touch, one contains a point of the surface between them: the
/// one on the side of larger x (and of 1/128 as much larger y, 1/256 z). For an open mesh the
/// answer is that of this one ray; winding_number says more. False for points that are not finite.
template <class Layout>
void contains(const Layout& bvh, const PointBatch& points, bool* answers);

/// The distance of closest_point, negative where the mesh contains the point.
template <class Layout>
void signed_distance(const Layout& bvh, const PointBatch& points, float* answers);

}  // namespace treelet
