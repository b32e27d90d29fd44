#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include <treelet/layout/bvh2.h>
#include <treelet/layout/bvh8.h>
#include <treelet/layout/cwbvh.h>
#include <treelet/query/point_batch.h>

namespace treelet {

/// The point of a mesh that is nearest to a given one: (1-u-v) P0 + u P1 + v P2 of the face.
/// None: NaN, infinite distance, face -1.
struct ClosestPoint {
  static constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

  Vec3 point{kNaN, kNaN, kNaN};
  float distance = std::numeric_limits<float>::infinity();
  std::int32_t face = -1;
  float u = 0.0f, v = 0.0f;

  bool is_none() const { return face < 0; }
};

/// Answers as arrays; null ones are not wanted.
struct ClosestPointArrays {
  Vec3* point = nullptr;
  float* distance = nullptr;
  std::int32_t* face = nullptr;
  float *u = nullptr, *v = nullptr;
};

// All for the layouts Bvh2, Bvh8 and Cwbvh, with the same answers.
//
// Distances are found in doubles from the triangles as given in floats, and rounded to float once:
// what is returned is off by at most one float, plus 2^-48 of the distance and the triangle's size
// (query/point_triangle_steps.h). Of equal distances, before that rounding, the smaller face wins;
// triangles that meet in the nearest point have equal ones. A point counts if its distance, rounded
// to float, is at most `max_distance`. There is none for points that are not finite, for a NaN or
// negative `max_distance`, nor beyond the largest float.

template <class Layout>
ClosestPoint closest_point(const Layout& bvh, Vec3 point,
                           float max_distance = std::numeric_limits<float>::infinity());

/// One answer a point, on all threads; the radii are the largest distances.
template <class Layout>
void closest_point(const Layout& bvh, const PointBatch& points, const ClosestPointArrays& answers);

}  // namespace treelet
