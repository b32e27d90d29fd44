#pragma once

#include <array>

#include <treelet/core/aabb.h>
#include <treelet/mesh/mesh.h>

namespace treelet {

/// A convex polygon in double: a triangle clipped by the six planes of a box, so at most
/// 3 + 6 vertices.
struct ClippedTriangle {
  std::array<std::array<double, 3>, 9> vertex;
  int size = 0;

  explicit ClippedTriangle(const Triangle& triangle);

  /// Keeps what lies inside the box. May leave nothing.
  void clip(const Aabb& box);
  double area() const;

 private:
  void clip_plane(int axis, double position, double side);
};

}  // namespace treelet
