#pragma once

#include <array>

#include <treelet/layout/cwbvh.h>
#include <treelet/layout/cwbvh_steps.h>

#include "support/box_rays.h"

namespace treelet::test {

/// A compressed node of one child, and a ray at the child.
struct GridCase {
  CwbvhNode node{};
  int slot = 0;
  Aabb child, scene;  ///< the child's exact box, and one around the node's
  Ray ray;
};

inline GridCase random_grid_case(Random& random, float scale) {
  const Aabb child = random_box(random);
  const Ray ray = random_ray_at(random, child);
  Aabb around = child;
  for (int i = 0; i < 2; ++i) {  // on some sides the child's are the node's
    Vec3 p = random.point(-2.0f, 3.0f);
    if (random.below(2) == 0) p.x = child.lower.x;
    if (random.below(2) == 0) p.y = child.upper.y;
    if (random.below(2) == 0) p.z = child.lower.z;
    around = merge(around, p);
  }
  GridCase grid;
  grid.child = scaled(child, scale);
  grid.ray = scaled(ray, scale);
  const Aabb node_box = scaled(around, scale);
  grid.scene = random.below(2) == 0 ? node_box : merge(node_box, random.point(-4.0f, 4.0f) * scale);
  grid.slot = int(random.below(CwbvhNode::kChildren));
  grid.node.meta[std::size_t(grid.slot)] = CwbvhNode::leaf_meta(0, 1);
  const CwbvhGrid cells(node_box);
  cells.write_to(grid.node);
  CwbvhPlanes(cells, grid.child).write_to(grid.node, grid.slot);
  return grid;
}

/// Products overflow floats in one, and the last has denormal numbers.
inline constexpr std::array kGridScales{Scale{"One", 1.0f}, Scale{"Huge", 1e30f},
                                        Scale{"Overflowing", 1e36f}, Scale{"Tiny", 1e-30f},
                                        Scale{"Denormal", 1e-40f}};

}  // namespace treelet::test
