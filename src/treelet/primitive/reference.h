#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

#include <treelet/core/aabb.h>
#include <treelet/core/array.h>
#include <treelet/mesh/mesh.h>

namespace treelet {

/// What a builder sees of a triangle: its box, in build space, and its face.
struct alignas(16) Reference {
  Vec3 lower;
  std::uint32_t face;
  Vec3 upper;
  std::uint32_t padding;  // to 32 bytes, two references a cache line; in use while splitting

  TREELET_HD Aabb box() const { return {lower, upper}; }
};
static_assert(sizeof(Reference) == 32);

/// The primitives of a build. Build space is the mesh scaled by 2^-scale_exponent, so that areas
/// neither overflow nor vanish at coordinates of 1e30 or 1e-30. Packed layouts take their boxes
/// from the mesh again: rounding here moves no hit.
struct References {
  Array<Reference> items;  ///< in face order
  Aabb bounds = Aabb::empty();
  int scale_exponent = 0;
  bool may_repeat_faces = false;  ///< true after splitting: a face may have several references
  std::size_t left_out_non_finite = 0;
  std::size_t left_out_degenerate = 0;

  std::size_t size() const { return items.size(); }
  /// Whether each reference has the number of its face: none was left out, none was split.
  bool are_all_faces() const {
    return !may_repeat_faces && left_out_non_finite == 0 && left_out_degenerate == 0;
  }
  std::uint32_t face(std::uint32_t reference) const {
    return are_all_faces() ? reference : items[reference].face;
  }
};

/// One reference for each regular triangle of a mesh whose indices have been checked.
References create_references(const Mesh& mesh);

/// Twice the centroid of a box: saves a rounding, and the scale does not matter to an order.
TREELET_HD constexpr Vec3 doubled_centroid(const Aabb& box) { return box.lower + box.upper; }

}  // namespace treelet
