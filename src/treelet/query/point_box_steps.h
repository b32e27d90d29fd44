#pragma once

#include <treelet/core/aabb.h>
#include <treelet/core/platform.h>
#include <treelet/primitive/power_of_two.h>
#include <treelet/query/point_triangle_steps.h>

// How far boxes are from a point, in floats, and never more than what is in them.
//
// The point is first moved into the scene's box, by g >= 0 along each axis. What is e farther
// along these axes has the squared distance
//
//     sum (g + e)^2 = sum g^2 + sum e (e + 2 g)
//
// and the last sum, the excess, is what boxes are compared by: it stays accurate where the point is
// many scene sizes away and all distances look the same. Lengths are scaled by a power of two to at
// most one, so that squares neither overflow nor vanish.

namespace treelet {

/// A point as the boxes of a scene see it.
struct PointInScene {
  float point[3];      ///< moved into the scene's box
  float twice_gap[3];  ///< scaled
  float scale;
  double outside;  ///< squared distance from the scene's box
  double slack;    ///< bound on the error of squared distances
  double squared_scale;
};

namespace point_steps {

constexpr double kTriangleError = 0x1p-46;  ///< of a squared distance, over distance^2 + size^2

TREELET_INLINE float larger(float a, float b) { return a < b ? b : a; }

/// How far a coordinate must move to be within the limits.
TREELET_INLINE double gap_to(float x, float lower, float upper) {
  return x < lower ? double(lower) - x : x > upper ? double(x) - upper : 0.0;
}

TREELET_INLINE PointInScene place_in_scene(const float* point, const float* lower,
                                           const float* upper) {
  PointInScene placed;
  double gap[3], longest = 0x1p-126, diagonal = 0.0;
  placed.outside = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double extent = double(upper[axis]) - lower[axis];
    gap[axis] = gap_to(point[axis], lower[axis], upper[axis]);
    longest = longest < extent ? extent : longest;
    longest = longest < gap[axis] ? gap[axis] : longest;
    diagonal += extent * extent;
    placed.outside += gap[axis] * gap[axis];
  }
  const int exponent = int(__builtin_bit_cast(std::uint64_t, longest) >> 52) - 1023;
  const int shift = exponent < -126 ? 127 : exponent > 125 ? -126 : -exponent - 1;
  const double scale = __builtin_bit_cast(double, std::uint64_t(1023 + shift) << 52);
  placed.scale = float(scale);
  placed.squared_scale = scale * scale;
  placed.slack = kTriangleError * diagonal;
  for (int axis = 0; axis < 3; ++axis) {
    const float x = point[axis];
    placed.point[axis] = x < lower[axis] ? lower[axis] : x > upper[axis] ? upper[axis] : x;
    placed.twice_gap[axis] = float(2.0 * gap[axis] * scale);
  }
  return placed;
}

/// Distances whose squares are beyond this do not round to `max_distance` or less.
TREELET_INLINE double largest_square(float max_distance) {
  const double rounded_up = double(max_distance) * (1.0 + 0x1p-23) + 0x1p-149;
  return rounded_up * rounded_up;
}

/// The largest excess of a box that may hold something at this squared distance: rounding an excess
/// is off by less than 2^-21 of it and 2^-126.
TREELET_INLINE float excess_limit(const PointInScene& placed, double squared_distance) {
  const double beyond = squared_distance * (1.0 + kTriangleError) + placed.slack - placed.outside;
  const double limit = beyond * placed.squared_scale * (1.0 + 0x1p-20);
  return float(limit < 0.0 ? 0.0 : limit) + 0x1p-126f;
}

TREELET_INLINE float excess(const PointInScene& placed, const float* lower, const float* upper) {
  float sum = 0.0f;
  for (int axis = 0; axis < 3; ++axis) {
    const float below = lower[axis] - placed.point[axis], above = placed.point[axis] - upper[axis];
    const float e = larger(larger(below, above), 0.0f) * placed.scale;
    sum += e * (e + placed.twice_gap[axis]);
  }
  return sum;
}

}  // namespace point_steps
}  // namespace treelet
