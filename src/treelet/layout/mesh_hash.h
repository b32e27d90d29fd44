#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <treelet/layout/bvh2.h>
#include <treelet/layout/bvh8.h>
#include <treelet/layout/cwbvh.h>

namespace treelet {

/// Tells meshes apart by what trees keep of them: the number of faces, and the corners of each
/// regular triangle with its face, relative to an offset. The same for every recipe, layout and
/// order of vertices. The mesh's indices must have been checked.
std::uint64_t hash_mesh(const Mesh& mesh, const std::array<double, 3>& offset = {});

/// The same from a tree over the mesh, which had so many faces.
std::uint64_t hash_mesh(const Bvh2& bvh, std::size_t faces,
                        const std::array<double, 3>& offset = {});
std::uint64_t hash_mesh(const Bvh8& bvh, std::size_t faces,
                        const std::array<double, 3>& offset = {});
std::uint64_t hash_mesh(const Cwbvh& bvh, std::size_t faces,
                        const std::array<double, 3>& offset = {});

}  // namespace treelet
