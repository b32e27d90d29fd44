#pragma once

#include <limits>

#include <treelet/core/aabb.h>
#include <treelet/primitive/split_steps.h>

// What the box of one leaf takes; layout/leaf_box.h says why that is enough.

namespace treelet {

/// A lower side of build space in mesh units. At the limit it may stand for anything beyond.
TREELET_HD constexpr float lower_in_mesh_units(float x, double scale) {
  return x > -kBuildSpaceLimit ? round_down(x * scale) : std::numeric_limits<float>::lowest();
}

/// A box of build space, rounded outwards; `scale` is that of mesh units.
TREELET_HD constexpr Aabb to_mesh_units(const Aabb& box, double scale) {
  const auto lower = [scale](float x) { return lower_in_mesh_units(x, scale); };
  const auto upper = [scale](float x) { return -lower_in_mesh_units(-x, scale); };
  return {{lower(box.lower.x), lower(box.lower.y), lower(box.lower.z)},
          {upper(box.upper.x), upper(box.upper.y), upper(box.upper.z)}};
}

}  // namespace treelet
