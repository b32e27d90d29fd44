#pragma once

#include <treelet/core/platform.h>

namespace treelet {

/// Three doubles: a point or a direction.
struct DoubleVec3 {
  double x, y, z;

  TREELET_INLINE constexpr double operator[](int axis) const {
    return axis == 0 ? x : axis == 1 ? y : z;
  }
  friend constexpr bool operator==(const DoubleVec3&, const DoubleVec3&) = default;
};

}  // namespace treelet
