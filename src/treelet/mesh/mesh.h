#pragma once

#include <array>
#include <cstdint>
#include <span>

#include <treelet/core/aabb.h>

namespace treelet {

/// Three vertex indices.
using Face = std::array<std::uint32_t, 3>;

/// Vertex positions of one triangle, in face order.
struct Triangle {
  Vec3 p0, p1, p2;

  friend constexpr bool operator==(const Triangle&, const Triangle&) = default;
};

TREELET_HD constexpr Aabb bounds(const Triangle& t) {
  return {min(min(t.p0, t.p1), t.p2), max(max(t.p0, t.p1), t.p2)};
}

/// Faces are numbered by 31 bits: a hit stores one as int32, -1 for a miss.
constexpr std::size_t kMaxFaces = 0x7fffffff;

/// An indexed triangle mesh that somebody else owns.
struct Mesh {
  std::span<const Vec3> vertices;
  std::span<const Face> faces;

  Triangle triangle(std::size_t face) const {
    const Face& f = faces[face];
    return {vertices[f[0]], vertices[f[1]], vertices[f[2]]};
  }
};

/// Throws std::invalid_argument that names the first face whose index is out of range, or when
/// there are more than kMaxFaces faces.
void check_indices(const Mesh& mesh);

/// What the build does with a triangle.
enum class TriangleKind {
  regular,
  non_finite,  ///< a vertex is NaN or infinite: no box, no hit
  degenerate,  ///< two vertices have equal positions: a segment that its neighbours also have
};

/// Collinear triangles with three distinct vertices are regular: they may close a T-junction.
TriangleKind classify(const Triangle& triangle);

}  // namespace treelet
