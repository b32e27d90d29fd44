#pragma once

#include <cstdint>

#include <treelet/core/array.h>
#include <treelet/layout/bvh2.h>
#include <treelet/layout/bvh8.h>
#include <treelet/layout/cwbvh.h>
#include <treelet/query/point_batch.h>

namespace treelet {

/// Faces in rows: row i is face[offsets[i]] to face[offsets[i + 1]], ascending, each once.
struct Overlaps {
  Array<std::int64_t> offsets;
  Array<std::int32_t> face;
};

/// Boxes as they lie in memory.
struct BoxBatch {
  std::size_t size = 0;
  PerRay<Vec3> lower, upper;
};

// For the layouts Bvh2, Bvh8 and Cwbvh, with the same answers, on all threads.

/// The faces that have a point in common with each box, both closed: touching counts, and nothing
/// is rounded (query/triangle_box.h). Boxes may be infinite; one with a NaN, or with lower beyond
/// upper, has no faces.
template <class Layout>
Overlaps overlap_boxes(const Layout& bvh, const BoxBatch& boxes);

/// The faces whose distance from the centre, as closest_point (query/closest_point.h) rounds it to
/// float, is at most the radius. None for a centre that is not finite, or a NaN or negative radius.
template <class Layout>
Overlaps overlap_spheres(const Layout& bvh, const PointBatch& spheres);

}  // namespace treelet
