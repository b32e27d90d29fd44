#pragma once

#include <span>

#include <treelet/core/double_vec.h>
#include <treelet/mesh/mesh.h>

namespace treelet {

/// Triangle (mesh/mesh.h) in doubles.
struct DoubleTriangle {
  DoubleVec3 p0, p1, p2;
};

/// Mesh in doubles, that somebody else owns.
struct DoubleMesh {
  std::span<const DoubleVec3> vertices;
  std::span<const Face> faces;

  DoubleTriangle triangle(std::size_t face) const {
    const Face& f = faces[face];
    return {vertices[f[0]], vertices[f[1]], vertices[f[2]]};
  }
};

/// As those of Mesh.
void check_indices(const DoubleMesh& mesh);
TriangleKind classify(const DoubleTriangle& triangle);

}  // namespace treelet
