#pragma once

#include <treelet/core/array.h>
#include <treelet/core/double_vec.h>
#include <treelet/mesh/double_mesh.h>

// How a mesh in doubles gets a tree of float boxes: boxes are those of the mesh moved to the origin
// and scaled to about one, rounded outwards; and a float mesh of one triangle for each of these
// boxes goes through the builders, which see nothing of a triangle but its box.

namespace treelet {

/// The space of the boxes: coordinates are (x - center) * 2^-exponent.
struct BoxFrame {
  DoubleVec3 center{0, 0, 0};
  int exponent = 0;                           ///< the boxes' coordinates are at most 2
  DoubleVec3 lower{0, 0, 0}, upper{0, 0, 0};  ///< of the regular triangles' vertices, exactly
  bool is_empty = true;
};

/// Fits the regular triangles of a mesh whose indices have been checked.
BoxFrame fit_frame(const DoubleMesh& mesh);

/// Triangles that are as regular as those of the double mesh, and whose boxes contain theirs.
struct BoxMesh {
  Array<Vec3> vertices;
  Array<Face> faces;

  Mesh view() const { return {vertices, faces}; }
};
BoxMesh make_box_mesh(const DoubleMesh& mesh, const BoxFrame& frame);

/// A box in the frame that contains the triangle. Its sides have a length, also where those of the
/// triangle's box do not.
Aabb box_in_frame(const DoubleTriangle& triangle, const BoxFrame& frame);

}  // namespace treelet
