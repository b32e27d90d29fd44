#pragma once

#include <array>
#include <ostream>
#include <string>

#include <treelet/core/ray.h>
#include <treelet/mesh/mesh.h>

#include "support/random.h"

namespace treelet::test {

struct RayCase {
  Triangle triangle;
  Ray ray;
};

/// How a ray is aimed at a triangle. Kinds on a grid have small whole coordinates, so that they hit
/// what they aim at exactly; the others miss it by their rounding.
enum class Aim {
  nearby,           ///< a random point near the triangle
  vertex,           ///< one of the vertices
  edge,             ///< a point of an edge
  grid_vertex,      ///< exactly a vertex
  grid_edge,        ///< exactly the middle of an edge
  grid_along_edge,  ///< from an edge's line along it
  grid_in_plane,    ///< within the plane of the triangle
  grid_axis,        ///< along a coordinate axis
  far_away,         ///< an edge, from a million extents away
  one_ulp_off,      ///< an edge, one direction component moved by a few units of the last place
};
inline constexpr std::array kAims{
    Aim::nearby,          Aim::vertex,        Aim::edge,      Aim::grid_vertex, Aim::grid_edge,
    Aim::grid_along_edge, Aim::grid_in_plane, Aim::grid_axis, Aim::far_away,    Aim::one_ulp_off};
std::string name(Aim aim);
/// What GoogleTest prints of a parameter.
inline std::ostream& operator<<(std::ostream& out, Aim aim) { return out << name(aim); }

RayCase random_case(Random& random, Aim aim);

}  // namespace treelet::test
