#pragma once

#include <string>
#include <vector>

#include <treelet/layout/bvh2.h>
#include <treelet/layout/bvh8.h>

namespace treelet {

/// What is wrong inside a packed tree, at most 20 sentences; empty for a sound one. Checks that
/// nodes and triangles are reached once, in depth-first order, and that boxes contain what they
/// hold: whole triangles, or of a triangle in several leaves, together all of it.
std::vector<std::string> validate(const Bvh2& bvh);
std::vector<std::string> validate(const Bvh8& bvh);

/// The same, and whether the triangles are the mesh's regular triangles, unchanged and none
/// missing. The mesh's indices must have been checked.
std::vector<std::string> validate(const Bvh2& bvh, const Mesh& mesh);
std::vector<std::string> validate(const Bvh8& bvh, const Mesh& mesh);

}  // namespace treelet
