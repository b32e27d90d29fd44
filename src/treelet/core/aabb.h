#pragma once

#include <limits>

#include <treelet/core/vec.h>

namespace treelet {

/// Axis-aligned bounding box, closed on all sides.
struct Aabb {
  Vec3 lower, upper;

  /// The box of nothing: growing it by a box gives that box, and no ray meets it.
  TREELET_HD static constexpr Aabb empty() {
    constexpr float inf = std::numeric_limits<float>::infinity();
    return {{inf, inf, inf}, {-inf, -inf, -inf}};
  }

  TREELET_HD constexpr bool is_empty() const { return !(lower.x <= upper.x); }
  TREELET_HD constexpr Vec3 extent() const { return upper - lower; }

  TREELET_HD constexpr bool contains(const Aabb& box) const {
    return box.is_empty() ||
           (lower.x <= box.lower.x && lower.y <= box.lower.y && lower.z <= box.lower.z &&
            upper.x >= box.upper.x && upper.y >= box.upper.y && upper.z >= box.upper.z);
  }

  friend constexpr bool operator==(const Aabb&, const Aabb&) = default;
};

TREELET_HD constexpr Aabb merge(const Aabb& a, const Aabb& b) {
  return {min(a.lower, b.lower), max(a.upper, b.upper)};
}
TREELET_HD constexpr Aabb merge(const Aabb& a, Vec3 point) {
  return {min(a.lower, point), max(a.upper, point)};
}

/// Half the surface area, in units of length squared. Overflows beyond extents of 1e19: builders
/// work in a space scaled to unit size (see primitive/reference.h).
TREELET_HD constexpr float half_area(const Aabb& box) {
  const Vec3 d = box.extent();
  return d.x * d.y + d.y * d.z + d.z * d.x;
}

/// The same in double, for statistics in the mesh's own units; 0 for an empty box.
constexpr double half_area_double(const Aabb& box) {
  if (box.is_empty()) return 0.0;
  const double x = double(box.upper.x) - box.lower.x;
  const double y = double(box.upper.y) - box.lower.y;
  const double z = double(box.upper.z) - box.lower.z;
  return x * y + y * z + z * x;
}

}  // namespace treelet
