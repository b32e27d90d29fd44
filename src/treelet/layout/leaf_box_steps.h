#pragma once

#include <treelet/core/aabb.h>
#include <treelet/primitive/split_steps.h>

// What the box of one leaf takes; layout/leaf_box.h says why that is enough.

namespace treelet {

/// A box of build space, rounded outwards; `scale` is that of mesh units.
TREELET_HD constexpr Aabb to_mesh_units(const Aabb& box, double scale) {
  return {{round_down(box.lower.x * scale), round_down(box.lower.y * scale),
           round_down(box.lower.z * scale)},
          {round_up(box.upper.x * scale), round_up(box.upper.y * scale),
           round_up(box.upper.z * scale)}};
}

}  // namespace treelet
