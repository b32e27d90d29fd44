#pragma once

#include <string>
#include <vector>

#include <treelet/layout/bvh2.h>
#include <treelet/layout/bvh8.h>
#include <treelet/layout/cwbvh.h>

namespace treelet {

/// What is wrong inside a packed tree, at most 20 sentences; empty for a sound one. Checks that
/// nodes and triangles are reached once, in the layout's order, and that boxes contain what they
/// hold: whole triangles, or of a triangle in several leaves, together all of it. What a child of a
/// cwbvh holds has to lie in the boxes that the planes of all nodes above it bound.
std::vector<std::string> validate(const Bvh2& bvh);
std::vector<std::string> validate(const Bvh8& bvh);
std::vector<std::string> validate(const Cwbvh& bvh);

/// The same, and whether the triangles are the mesh's regular triangles, unchanged and none
/// missing. The mesh's indices must have been checked.
std::vector<std::string> validate(const Bvh2& bvh, const Mesh& mesh);
std::vector<std::string> validate(const Bvh8& bvh, const Mesh& mesh);
std::vector<std::string> validate(const Cwbvh& bvh, const Mesh& mesh);

}  // namespace treelet
