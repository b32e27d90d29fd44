#pragma once

#include <cstdint>
#include <vector>

#include <treelet/core/ray.h>
#include <treelet/mesh/mesh.h>

namespace treelet::test {

/// Rays of every kind that tends to go wrong, `count` of each: random ones through the mesh's box,
/// along axes through vertices, at vertices, at points of edges, from a million extents away, and
/// with limits on t.
std::vector<Ray> rays_at(const Mesh& mesh, std::size_t count, std::uint64_t seed);

}  // namespace treelet::test
