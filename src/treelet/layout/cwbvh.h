#pragma once

#include <array>
#include <cstdint>

#include <treelet/core/aabb.h>
#include <treelet/core/array.h>
#include <treelet/core/platform.h>
#include <treelet/mesh/mesh.h>

namespace treelet {

/// Eight children in 80 bytes, which a device reads in five loads of 16 [YlitieKarrasLaine2017 s3].
/// Their boxes lie on a grid of 256 planes an axis, rounded outwards: lower and upper planes are at
/// origin + q * 2^(exponent - 127), which contain the child's box in exact arithmetic; see
/// layout/cwbvh_steps.h. A child of a node may reach out of the node's own box by a cell.
///
/// Children sit in slots by the octant of the node they lie in: bit 0, 1, 2 of a slot is set for
/// the upper side of x, y, z. With the bits of `signs` set where a ray's direction is negative, it
/// meets them in about the order of slot ^ signs. Slots may be empty.
struct alignas(16) CwbvhNode {
  static constexpr int kChildren = 8;
  static constexpr int kMaxLeaf = 3;
  static constexpr std::uint8_t kNodeOffset = 24;  ///< in meta: above the offsets of triangles

  Vec3 origin;                           ///< lower corner of the exact box of the node
  std::array<std::uint8_t, 3> exponent;  ///< of the cells, biased as in a float; 1 to 254
  std::uint8_t node_mask;                ///< bit i: child i is a node
  std::uint32_t first_node;              ///< children that are nodes lie here, in order of slots
  std::uint32_t first_triangle;          ///< triangles of all leaves of the node: one run
  /// 0: no child. A node: 0b001 and 24 + slot. A leaf: in the upper 3 bits as many ones from below
  /// as it has triangles, in the lower 5 the offset of the first from first_triangle.
  std::array<std::uint8_t, kChildren> meta;
  std::uint8_t lower[3][kChildren], upper[3][kChildren];  ///< planes, by axis; 0 of no child

  TREELET_HD bool is_none(int slot) const { return meta[slot] == 0; }
  TREELET_HD bool is_node(int slot) const { return (node_mask >> slot & 1) != 0; }
  TREELET_HD bool is_leaf(int slot) const { return !is_none(slot) && !is_node(slot); }

  /// Of a child that is a node.
  TREELET_HD std::uint32_t node(int slot) const {
    std::uint32_t before = node_mask & ((1u << slot) - 1), count = 0;
    for (; before != 0; before &= before - 1) ++count;
    return first_node + count;
  }
  /// Of a leaf.
  TREELET_HD std::uint32_t triangle(int slot) const { return first_triangle + (meta[slot] & 31); }
  /// Of a leaf: 0b001, 0b011 or 0b111 in the upper bits.
  TREELET_HD std::uint32_t triangle_count(int slot) const {
    const std::uint32_t unary = meta[slot] >> 5;
    return unary - (unary >> 1) - (unary >> 2);
  }

  TREELET_HD static constexpr std::uint8_t node_meta(int slot) {
    return std::uint8_t(1 << 5 | (kNodeOffset + slot));
  }
  TREELET_HD static constexpr std::uint8_t leaf_meta(std::uint32_t offset, std::uint32_t count) {
    return std::uint8_t(((1u << count) - 1) << 5 | offset);
  }
};
static_assert(sizeof(CwbvhNode) == 80);

/// A triangle that a device reads in three loads of 16 bytes.
struct alignas(16) CwbvhTriangle {
  Vec3 p0;
  std::uint32_t face;
  Vec3 p1;
  std::uint32_t reserved1;  ///< zero
  Vec3 p2;
  std::uint32_t reserved2;  ///< zero

  TREELET_HD Triangle triangle() const { return {p0, p1, p2}; }
};
static_assert(sizeof(CwbvhTriangle) == 48);

/// The compressed eight-wide layout. Parents lie before children, children of a node side by side;
/// the triangles of a subtree are one run, those of a node's leaves first. Without triangles there
/// are no nodes.
struct Cwbvh {
  Array<CwbvhNode> nodes;
  Array<CwbvhTriangle> triangles;
  Aabb bounds = Aabb::empty();  ///< exact
  std::uint32_t depth = 0;      ///< nodes on the longest way from the root to a leaf

  std::size_t bytes() const { return nodes.bytes() + triangles.bytes(); }
};

}  // namespace treelet
