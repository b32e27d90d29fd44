#pragma once

#include <array>
#include <cstdint>

#include <treelet/core/aabb.h>
#include <treelet/core/array.h>
#include <treelet/core/platform.h>
#include <treelet/mesh/mesh.h>

namespace treelet {

/// A node that holds its children's boxes: one cache line decides about both [AilaLaine2009].
struct alignas(64) Bvh2Node {
  std::array<Aabb, 2> box;
  std::array<std::uint32_t, 2> index;  ///< internal child: its node; leaf: its first triangle
  std::array<std::uint32_t, 2> count;  ///< triangles of a leaf; 0 for an internal child

  TREELET_HD bool is_leaf(int child) const { return count[child] > 0; }
  /// The place beside a tree's only leaf: no child, for the root is nobody's.
  TREELET_HD bool is_none(int child) const { return count[child] == 0 && index[child] == 0; }
};
static_assert(sizeof(Bvh2Node) == 64);

/// Vertices by value: a leaf reads one run of memory.
struct PackedTriangle {
  Vec3 p0, p1, p2;
  std::uint32_t face;

  TREELET_HD Triangle triangle() const { return {p0, p1, p2}; }
};
static_assert(sizeof(PackedTriangle) == 40);

/// The binary layout for traversal. Nodes lie in depth-first order, parents before children; the
/// triangles of a subtree are one run. Boxes are exact unions of float vertices in mesh units.
/// A mesh of one leaf has a root whose second child is an empty box; without triangles there are no
/// nodes.
struct Bvh2 {
  Array<Bvh2Node> nodes;
  Array<PackedTriangle> triangles;  ///< in leaf order
  Aabb bounds = Aabb::empty();
  std::uint32_t depth = 0;  ///< nodes on the longest way from the root to a leaf

  bool is_single_leaf() const { return nodes.size() == 1 && nodes[0].box[1].is_empty(); }
  std::size_t bytes() const { return nodes.bytes() + triangles.bytes(); }
};

}  // namespace treelet
