#pragma once

#include <cstdint>

#include <treelet/core/aabb.h>
#include <treelet/core/platform.h>
#include <treelet/core/ray.h>
#include <treelet/primitive/morton.h>
#include <treelet/traverse/is_traceable.h>

// By which number rays are sorted. It decides when a ray is traced, never what it hits, so floats
// may round, overflow or be NaN here as they like.

namespace treelet {

/// Cubic cells over a scene's box.
struct RayGrid {
  Vec3 lower;
  float scale;  ///< longest sides of the box a unit
  Vec3 size;    ///< of the box, in longest sides
};

TREELET_HD constexpr RayGrid make_ray_grid(const Aabb& bounds) {
  if (bounds.is_empty()) return {{0, 0, 0}, 0.0f, {0, 0, 0}};
  const Vec3 extent = bounds.extent();
  const float longest = max_component(extent);
  const float scale = longest > 0.0f ? 1.0f / longest : 0.0f;
  return {bounds.lower, scale, extent * scale};
}

/// Of rays that the box stops: behind all others, which they would only hold up.
constexpr std::uint32_t kMissKey = 0xffffffff;

namespace detail {

constexpr int kRayCellBits = 7;       // an axis
constexpr int kRayDirectionBits = 4;  // a coordinate of an octant's triangle

/// The cell of [0, 1] that a coordinate lies in; the first for NaN.
TREELET_HD constexpr std::uint32_t ray_cell(float x, int bits) {
  const float last = float((1u << bits) - 1);
  const float cell = x * float(1u << bits);
  return std::uint32_t(cell > 0.0f ? min(cell, last) : 0.0f);
}

struct RayRange {
  float begin, end;
};

/// What of [t_min, t_max] lies between the sides of the box.
TREELET_HD inline RayRange clip_to_box(Vec3 origin, Vec3 direction, Vec3 size, RayRange range) {
  for (int axis = 0; axis < 3; ++axis) {
    const float inverse = 1.0f / direction[axis];
    const float t0 = -origin[axis] * inverse, t1 = (size[axis] - origin[axis]) * inverse;
    range.begin = max(range.begin, min(t0, t1));
    range.end = min(range.end, max(t0, t1));
  }
  return range;
}

/// 21 bits along a Z-order curve.
TREELET_HD inline std::uint32_t point_key(Vec3 p) {
  const auto spread = [](float x) { return std::uint32_t(spread_by_3(ray_cell(x, kRayCellBits))); };
  return spread(p.x) << 2 | spread(p.y) << 1 | spread(p.z);
}

/// 11 bits: the octant, and within it where the direction meets the plane x + y + z = 1.
TREELET_HD inline std::uint32_t direction_key(Vec3 d) {
  const auto magnitude = [](float x) { return x < 0.0f ? -x : x; };
  const Vec3 a{magnitude(d.x), magnitude(d.y), magnitude(d.z)};
  const float inverse = 1.0f / (a.x + a.y + a.z);
  const std::uint32_t octant = (d.x < 0.0f) << 2 | (d.y < 0.0f) << 1 | (d.z < 0.0f);
  const auto spread = [&](float x) {
    return std::uint32_t(spread_by_2(ray_cell(x * inverse, kRayDirectionBits)));
  };
  return octant << 2 * kRayDirectionBits | spread(a.x) << 1 | spread(a.y);
}

/// From the top: coarse place, coarse direction, fine place, fine direction. Of a dozen mixtures
/// this lets both 32 and 2048 neighbouring rays share the most nodes. Differs from
/// [Meister2020], who also estimate where rays end.
TREELET_HD constexpr std::uint32_t mix_keys(std::uint32_t point, std::uint32_t heading) {
  constexpr int kCoarseHeading = 5, kFinePoint = 9, kFineHeading = 6;  // bits
  const std::uint32_t coarse = point >> kFinePoint << kCoarseHeading | heading >> kFineHeading;
  const std::uint32_t fine_point = point & ((1u << kFinePoint) - 1);
  const std::uint32_t fine_heading = heading & ((1u << kFineHeading) - 1);
  return (coarse << kFinePoint | fine_point) << kFineHeading | fine_heading;
}

}  // namespace detail

/// Rays with keys near each other start in the box near each other and head the same way.
TREELET_HD inline std::uint32_t ray_key(const RayGrid& grid, const Ray& ray) {
  if (!is_traceable(ray)) return kMissKey;
  const Vec3 origin = (ray.origin - grid.lower) * grid.scale;
  const Vec3 direction = ray.direction * grid.scale;
  const auto range = detail::clip_to_box(origin, direction, grid.size, {ray.t_min, ray.t_max});
  if (range.begin > range.end) return kMissKey;
  return detail::mix_keys(detail::point_key(origin + direction * range.begin),
                          detail::direction_key(ray.direction));
}

}  // namespace treelet
