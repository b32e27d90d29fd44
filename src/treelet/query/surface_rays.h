#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <treelet/core/ray.h>
#include <treelet/mesh/mesh.h>

namespace treelet {

/// Rays that leave a mesh's surface, as diffuse light does: from points spread evenly over its
/// area, on a random side, in cosine-distributed directions. About `count`, in face order, the same
/// for any number of threads; none for a mesh without area.
std::vector<Ray> make_surface_rays(const Mesh& mesh, std::size_t count, std::uint64_t seed = 0);

}  // namespace treelet
