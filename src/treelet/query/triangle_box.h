#pragma once

#include <treelet/core/aabb.h>
#include <treelet/mesh/mesh.h>

namespace treelet {

/// Whether a triangle and a box have a point in common; both are closed. Decided without rounding.
/// Coordinates must be finite and the box not empty.
bool overlaps(const Triangle& triangle, const Aabb& box);

}  // namespace treelet
