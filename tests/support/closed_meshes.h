#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "support/meshes.h"

namespace treelet::test {

/// A unit cube of twelve triangles, from 0 to 1.
OwnedMesh cube();
/// A torus about the z axis, radii 1 and 0.4.
OwnedMesh torus(std::uint32_t around, std::uint32_t across);
/// `count` cubes that share their faces, coplanar ones on each other.
OwnedMesh stacked_cubes(std::uint32_t count);
/// Tetrahedra anywhere in the unit cube, which pass through each other, with random orders of
/// corners; coordinates are multiples of 1 / 16, so that many things touch.
OwnedMesh tetrahedra(std::size_t count, std::uint64_t seed);

/// Meshes each of whose edges, by positions, has an even number of triangles.
std::vector<NamedMesh> closed_meshes();

}  // namespace treelet::test
