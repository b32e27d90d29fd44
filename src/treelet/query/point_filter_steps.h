#pragma once

#include <treelet/core/platform.h>
#include <treelet/query/point_box_steps.h>

// Rules out triangles in floats before doubles measure the others, for one triangle or for lanes of
// them.
//
// For any vector d, no point of a triangle with vertices V_i, relative to the point, is nearer than
//
//     min d . V_i / |d|     and     - max d . V_i / |d|
//
// This is tight to second order for the direction of a small or far triangle's middle, and for the
// normal of a large and near one. As any d will do, its own rounding does not matter: with m the
// largest coordinate of the V_i, d . V_i is off by less than 4u m |d|_1.

namespace treelet::point_steps {

/// Arithmetic of one float; kernels have one of lanes.
struct OneFloat {
  using Number = float;
  static TREELET_INLINE float of(float x) { return x; }
  static TREELET_INLINE float min(float a, float b) { return b < a ? b : a; }
  static TREELET_INLINE float max(float a, float b) { return a < b ? b : a; }
  static TREELET_INLINE float magnitude(float x) { return x < 0.0f ? -x : x; }
};

/// A triangle as seen from the point, scaled.
template <class Math>
struct TriangleFilter {
  using F = typename Math::Number;
  using V = Vector<F>;
  V a, b, c;
  F largest;  ///< coordinate

  TREELET_INLINE TriangleFilter(const V& point, F scale, const V& p0, const V& p1, const V& p2)
      : a((p0 - point) * scale),
        b((p1 - point) * scale),
        c((p2 - point) * scale),
        largest(Math::max(Math::max(largest_of(a), largest_of(b)), largest_of(c))) {}

  /// Whether everything is farther than the square root of `limit` in this direction.
  TREELET_INLINE auto is_beyond(const V& d, F limit) const {
    const F at_a = dot(a, d), at_b = dot(b, d), at_c = dot(c, d);
    const F least = Math::min(Math::min(at_a, at_b), at_c);
    const F most = Math::max(Math::max(at_a, at_b), at_c);
    const F length = Math::magnitude(d.x) + Math::magnitude(d.y) + Math::magnitude(d.z);
    const F error = Math::of(0x1p-20f) * largest * length + Math::of(0x1p-120f);
    const F distance = Math::max(least, -most) - error;
    return (distance > F{}) & (distance * distance > limit * dot(d, d) + Math::of(0x1p-120f));
  }

  TREELET_INLINE auto is_beyond(F limit) const {
    return is_beyond(a + b + c, limit) | is_beyond(cross(b - a, c - a), limit);
  }

 private:
  static TREELET_INLINE F largest_of(const V& v) {
    return Math::max(Math::max(Math::magnitude(v.x), Math::magnitude(v.y)), Math::magnitude(v.z));
  }
};

/// What is_beyond() compares with: squared distances that round to more are farther.
TREELET_INLINE float filter_limit(const PointInScene& placed, double squared_distance) {
  const double limit = squared_distance * (1.0 + kTriangleError) + placed.slack;
  return float(limit * placed.squared_scale * (1.0 + 0x1p-18));
}

}  // namespace treelet::point_steps
