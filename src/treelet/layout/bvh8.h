#pragma once

#include <array>
#include <cstdint>

#include <treelet/core/aabb.h>
#include <treelet/core/array.h>
#include <treelet/core/platform.h>
#include <treelet/mesh/mesh.h>

namespace treelet {

/// Up to four triangles, a coordinate of all of them side by side. Lanes without a triangle repeat
/// the first and have no face.
struct alignas(32) TriangleBlock {
  static constexpr std::uint32_t kTriangles = 4;
  static constexpr std::uint32_t kNoFace = 0xffffffff;

  float vertex[3][3][kTriangles];  ///< by corner, then axis
  std::uint32_t face[kTriangles];

  TREELET_HD Triangle triangle(std::uint32_t lane) const {
    const auto corner = [&](int i) {
      return Vec3{vertex[i][0][lane], vertex[i][1][lane], vertex[i][2][lane]};
    };
    return {corner(0), corner(1), corner(2)};
  }
};
static_assert(sizeof(TriangleBlock) == 160);

/// Where a child is: a node, or a leaf of one to four blocks.
struct WideChild {
  static constexpr std::uint32_t kLeafBit = 0x80000000;
  static constexpr std::uint32_t kMaxBlocks = 4;
  static constexpr std::uint32_t kMaxBlockIndex = 0x1fffffff;
  static constexpr std::uint32_t kNone = 0;  // the root is nobody's child

  std::uint32_t bits;

  TREELET_HD static constexpr WideChild node(std::uint32_t index) { return {index}; }
  TREELET_HD static constexpr WideChild leaf(std::uint32_t block, std::uint32_t blocks) {
    return {kLeafBit | (blocks - 1) << 29 | block};
  }
  TREELET_INLINE constexpr bool is_leaf() const { return (bits & kLeafBit) != 0; }
  TREELET_INLINE constexpr bool is_none() const { return bits == kNone; }
  TREELET_INLINE constexpr std::uint32_t node() const { return bits; }
  TREELET_INLINE constexpr std::uint32_t first_block() const { return bits & kMaxBlockIndex; }
  TREELET_INLINE constexpr std::uint32_t block_count() const { return (bits >> 29 & 3) + 1; }
};

/// Eight children's boxes, an axis of all of them side by side: one ray is tested against all at
/// once. Unused children come last and have empty boxes.
struct alignas(64) Bvh8Node {
  static constexpr int kChildren = 8;

  float planes[6][kChildren];  ///< lower x, y, z, then upper x, y, z
  WideChild child[kChildren];
  std::uint32_t reserved[8];  ///< zero: fills the fourth cache line

  TREELET_HD Aabb box(int i) const {
    return {{planes[0][i], planes[1][i], planes[2][i]}, {planes[3][i], planes[4][i], planes[5][i]}};
  }
  TREELET_HD void set_box(int i, const Aabb& box) {
    for (int axis = 0; axis < 3; ++axis) {
      planes[axis][i] = box.lower[axis];
      planes[axis + 3][i] = box.upper[axis];
    }
  }
};
static_assert(sizeof(Bvh8Node) == 256);

/// The eight-wide layout for the CPU. Parents lie before children; the blocks of a subtree are one
/// run. Boxes are exact unions of float vertices in mesh units. Without triangles there are no
/// nodes.
struct Bvh8 {
  Array<Bvh8Node> nodes;
  Array<TriangleBlock> blocks;
  Aabb bounds = Aabb::empty();
  std::uint32_t depth = 0;  ///< nodes on the longest way from the root to a leaf
  std::size_t triangle_count = 0;

  std::size_t bytes() const { return nodes.bytes() + blocks.bytes(); }
};

}  // namespace treelet
