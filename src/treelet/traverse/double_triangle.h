#pragma once

#include <treelet/core/double_ray.h>
#include <treelet/mesh/double_mesh.h>
#include <treelet/traverse/double_ray_setup.h>

// The ray-triangle tests of traverse/ray_triangle.h and traverse/crossing.h in doubles: the same
// rules, for rays and triangles as given in doubles. A filter in doubles decides nearly all, and
// integers as wide as it takes the rest, so there is no magnitude for which an answer is wrong.

namespace treelet {

/// Bound on the rounding of an edge function in doubles, over what it is in
/// traverse_bvh8_exact.inl.
inline constexpr double kDoubleEdgeBound = 0x1p-48;  // 32u, for u = 2^-53
/// What underflow can take of it: a product loses 2^-1074, and is multiplied by a coordinate that
/// is either small, too, or makes the bound large.
inline constexpr double kUnderflow = 0x1p-1000;

/// Whether the ray's whole line meets the triangle, edges included; not where it is seen edge-on.
bool meets(const DoubleRaySetup& setup, const DoubleTriangle& triangle);

/// Whether it crosses the triangle by the fill rule (traverse/crossing.h).
bool crosses(const DoubleRaySetup& setup, const DoubleTriangle& triangle);

/// A coordinate of a hit.
enum class Place { t, u, v };

/// Where the line meets the triangle that it meets or crosses: the exact value, rounded to nearest.
/// Not zero unless it is exactly.
double place_exactly(const DoubleRay& ray, const DoubleTriangle& triangle, Place place);

}  // namespace treelet
