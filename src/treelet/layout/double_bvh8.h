#pragma once

#include <cstdint>

#include <treelet/core/array.h>
#include <treelet/layout/bvh8.h>
#include <treelet/mesh/double_boxes.h>

namespace treelet {

/// TriangleBlock (layout/bvh8.h) in doubles.
struct alignas(64) DoubleBlock {
  static constexpr std::uint32_t kTriangles = TriangleBlock::kTriangles;
  static constexpr std::uint32_t kNoFace = TriangleBlock::kNoFace;

  double vertex[3][3][kTriangles];  ///< by corner, then axis
  std::uint32_t face[kTriangles];

  DoubleTriangle triangle(unsigned lane) const {
    const auto corner = [&](int i) {
      return DoubleVec3{vertex[i][0][lane], vertex[i][1][lane], vertex[i][2][lane]};
    };
    return {corner(0), corner(1), corner(2)};
  }
};
static_assert(sizeof(DoubleBlock) == 320);

/// Bvh8 over triangles in doubles: the nodes' boxes lie in a frame, the triangles where the mesh
/// has them. No face is in two leaves.
struct DoubleBvh8 {
  Array<Bvh8Node> nodes;
  Array<DoubleBlock> blocks;
  BoxFrame frame;
  Aabb bounds = Aabb::empty();  ///< of the boxes, in the frame
  std::uint32_t depth = 0;

  std::size_t bytes() const { return nodes.bytes() + blocks.bytes(); }
};

/// Takes the nodes of a tree over make_box_mesh(mesh, frame), and the mesh's own triangles in the
/// order of its leaves.
DoubleBvh8 pack_double_bvh8(Bvh8&& boxes, const DoubleMesh& mesh, const BoxFrame& frame);

}  // namespace treelet
