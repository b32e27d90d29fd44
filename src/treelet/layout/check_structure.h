#pragma once

#include <cstddef>
#include <string>

#include <treelet/layout/bvh2.h>
#include <treelet/layout/bvh8.h>
#include <treelet/layout/cwbvh.h>

namespace treelet {

/// For trees that come from outside: the first thing that could lead whatever walks the tree out of
/// its arrays, in circles, or to a face that the mesh of so many faces lacks; empty if there is
/// none. Every node is reached once, from a node before it; every place for triangles is in one
/// leaf; the depth is right; boxes are boxes, and vertices are finite. Whether boxes contain what
/// they hold is asked by validate() (layout/validate_layout.h).
std::string find_unsafe_part(const Bvh2& bvh, std::size_t faces);
std::string find_unsafe_part(const Bvh8& bvh, std::size_t faces);
std::string find_unsafe_part(const Cwbvh& bvh, std::size_t faces);

}  // namespace treelet
