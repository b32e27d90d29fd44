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

/// Throws std::invalid_argument where there are more than kMaxFaces.
void check_face_count(std::size_t faces);

/// Throws std::invalid_argument that names the first face whose index is out of range, or when
/// there are more than kMaxFaces faces.
void check_indices(const Mesh& mesh);

/// What check_indices throws for a face with a bad index.
[[noreturn]] void throw_bad_index(std::size_t face, const Face& corners, std::size_t vertices);

/// What the build does with a triangle.
enum class TriangleKind {
  regular,
  non_finite,  ///< a vertex is NaN or infinite: no box, no hit
  degenerate,  ///< two vertices have equal positions: a segment that its neighbours also have
};

TREELET_HD constexpr bool is_finite(Vec3 p) {
  return p.x - p.x == 0.0f && p.y - p.y == 0.0f && p.z - p.z == 0.0f;
}

/// Collinear triangles with three distinct vertices are regular: they may close a T-junction.
TREELET_HD constexpr TriangleKind classify(const Triangle& t) {
  if (!is_finite(t.p0) || !is_finite(t.p1) || !is_finite(t.p2)) return TriangleKind::non_finite;
  if (t.p0 == t.p1 || t.p1 == t.p2 || t.p2 == t.p0) return TriangleKind::degenerate;
  return TriangleKind::regular;
}

}  // namespace treelet
