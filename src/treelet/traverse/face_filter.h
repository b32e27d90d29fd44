#pragma once

#include <cstdint>

#include <treelet/core/platform.h>
#include <treelet/core/vec.h>
#include <treelet/mesh/mesh.h>

namespace treelet {

/// Faces that a ray passes through by the side that it sees. It sees the front where the corners go
/// counter-clockwise.
enum class Cull : std::uint8_t { none, back, front };

/// The exact sign of direction . ((p1 - p0) x (p2 - p0)): -1 where a ray sees the triangle's front,
/// 1 where it sees its back, 0 where it sees it edge-on and so does not meet it. It is the sign of
/// U + V + W in traverse/ray_triangle.h, so a ray sees one side or the other of all that it meets.
int side_of(Vec3 direction, const Triangle& triangle);

/// Which faces rays can hit; the others are as if they were not there.
struct FaceFilter {
  Cull cull = Cull::none;
  const bool* mask = nullptr;  ///< one a face of the mesh, false where rays pass; null: all true

  TREELET_INLINE bool is_open() const { return cull == Cull::none && mask == nullptr; }
  TREELET_INLINE bool has(std::uint32_t face) const { return mask == nullptr || mask[face]; }
  /// Whether a ray that meets the triangle is stopped by the side that it sees.
  bool shows(Vec3 direction, const Triangle& triangle) const;
};

}  // namespace treelet
