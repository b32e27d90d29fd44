#include <treelet/layout/mesh_hash.h>

#include <bit>
#include <functional>
#include <vector>

#include <treelet/core/parallel.h>
#include <treelet/core/xxh64.h>
#include <treelet/layout/child_view.h>

namespace treelet {
namespace {

using Offset = std::array<double, 3>;

constexpr std::size_t kFacesPerTask = 1 << 14;

/// 0 for a triangle that trees leave out, or that a refit has hidden.
std::uint64_t hash_triangle(const Triangle& triangle, std::size_t face) {
  if (classify(triangle) != TriangleKind::regular) return 0;
  const PackedTriangle packed{triangle.p0, triangle.p1, triangle.p2, std::uint32_t(face)};
  return xxh64(std::as_bytes(std::span(&packed, 1)));
}

/// Sums commute: a tree has the triangles in an order of its own.
std::uint64_t finish(std::uint64_t sum, std::size_t faces, const Offset& offset) {
  std::uint64_t parts[5] = {sum, faces};
  for (int axis = 0; axis < 3; ++axis) {
    parts[2 + axis] = std::bit_cast<std::uint64_t>(offset[axis] + 0.0);  // -0 to +0
  }
  return xxh64(std::as_bytes(std::span(parts)));
}

/// A face that was split counts once.
template <class Layout>
std::uint64_t hash_tree(const Layout& bvh, std::size_t faces, const Offset& offset) {
  std::vector<bool> is_seen(faces, false);
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < position_count(bvh); ++i) {
    const std::uint32_t face = face_at(bvh, i);
    if (face >= faces || is_seen[face]) continue;
    is_seen[face] = true;
    sum += hash_triangle(triangle_at(bvh, i), face);
  }
  return finish(sum, faces, offset);
}

}  // namespace

std::uint64_t hash_mesh(const Mesh& mesh, const Offset& offset) {
  const auto hash_range = [&](std::size_t begin, std::size_t end) {
    std::uint64_t sum = 0;
    for (std::size_t face = begin; face < end; ++face) {
      sum += hash_triangle(mesh.triangle(face), face);
    }
    return sum;
  };
  return finish(parallel_reduce(mesh.faces.size(), kFacesPerTask, std::uint64_t{0}, hash_range,
                                std::plus<>()),
                mesh.faces.size(), offset);
}

std::uint64_t hash_mesh(const Bvh2& bvh, std::size_t faces, const Offset& offset) {
  return hash_tree(bvh, faces, offset);
}
std::uint64_t hash_mesh(const Bvh8& bvh, std::size_t faces, const Offset& offset) {
  return hash_tree(bvh, faces, offset);
}
std::uint64_t hash_mesh(const Cwbvh& bvh, std::size_t faces, const Offset& offset) {
  return hash_tree(bvh, faces, offset);
}

}  // namespace treelet
