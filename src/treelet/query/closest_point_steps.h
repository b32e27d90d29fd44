#pragma once

#include <cmath>
#include <limits>

#include <treelet/core/platform.h>
#include <treelet/mesh/mesh.h>
#include <treelet/query/closest_point.h>
#include <treelet/query/nearest.h>
#include <treelet/query/point_triangle_steps.h>

// From a point's nearest triangle to what is said of it. Host and device call it.

namespace treelet::point_steps {

TREELET_HD inline bool has_answer(Vec3 point, float max_distance) {
  return is_finite(point) && max_distance >= 0.0f;
}

TREELET_HD inline Vec3 rounded(const DoubleVector& p) {
  return {float(p.x), float(p.y), float(p.z)};
}

/// Whether the nearest triangle counts: its distance, rounded, is no more than that.
TREELET_HD inline bool is_within(const Nearest& nearest, float max_distance) {
  if (nearest.is_none()) return false;
  const double distance = std::sqrt(nearest.squared_distance);
  return distance <= double(std::numeric_limits<float>::max()) && float(distance) <= max_distance;
}

/// Of a triangle that counts.
TREELET_HD inline ClosestPoint describe(Vec3 point, const Nearest& nearest,
                                        const Triangle& triangle) {
  const auto found = nearest_point(view_from(point, triangle));
  return {rounded(widen(point) + found.offset), float(std::sqrt(nearest.squared_distance)),
          std::int32_t(nearest.face), float(found.u), float(found.v)};
}

TREELET_HD inline void put(const ClosestPointArrays& answers, std::size_t i,
                           const ClosestPoint& answer) {
  if (answers.point != nullptr) answers.point[i] = answer.point;
  if (answers.distance != nullptr) answers.distance[i] = answer.distance;
  if (answers.face != nullptr) answers.face[i] = answer.face;
  if (answers.u != nullptr) answers.u[i] = answer.u;
  if (answers.v != nullptr) answers.v[i] = answer.v;
}

}  // namespace treelet::point_steps
