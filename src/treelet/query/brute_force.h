#pragma once

#include <treelet/core/ray.h>
#include <treelet/mesh/mesh.h>

namespace treelet {

/// The closest hit found by testing every triangle: what every tree must answer. O(faces) a ray.
/// The mesh's indices must have been checked.
Hit intersect_brute_force(const Mesh& mesh, const Ray& ray);

}  // namespace treelet
