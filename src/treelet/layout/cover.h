#pragma once

#include <span>

#include <treelet/core/aabb.h>
#include <treelet/mesh/mesh.h>

namespace treelet {

/// Area of what the boxes leave of a triangle, up to the rounding of doubles.
double uncovered_area(const Triangle& triangle, std::span<const Aabb> boxes);

/// Whether each point of a triangle lies in one of the boxes, as far as doubles can tell: a gap of
/// an ulp of float is found.
bool covers(std::span<const Aabb> boxes, const Triangle& triangle);

}  // namespace treelet
