#pragma once

#include <cstdint>

#include <treelet/layout/bvh2.h>
#include <treelet/layout/bvh8.h>
#include <treelet/layout/cwbvh.h>
#include <treelet/layout/cwbvh_steps.h>

// One way to read and write the nodes and triangles of all layouts, for steps that host and device
// share. A position numbers the places for triangles in leaf order, as in layout/child_view.h.

namespace treelet {

template <class Node>
inline constexpr int kChildren = 0;
template <>
inline constexpr int kChildren<Bvh2Node> = 2;
template <>
inline constexpr int kChildren<Bvh8Node> = Bvh8Node::kChildren;
template <>
inline constexpr int kChildren<CwbvhNode> = CwbvhNode::kChildren;

/// Positions of a leaf.
struct PositionRange {
  std::uint32_t begin, end;
};

TREELET_HD inline bool is_leaf_child(const Bvh2Node& node, int i) { return node.count[i] > 0; }
TREELET_HD inline bool is_leaf_child(const Bvh8Node& node, int i) {
  return node.child[i].is_leaf();
}
TREELET_HD inline bool is_leaf_child(const CwbvhNode& node, int i) { return node.is_leaf(i); }

/// Whether a child is a node; else it is a leaf or not there.
TREELET_HD inline bool is_node_child(const Bvh2Node& node, int i) {
  return node.count[i] == 0 && node.index[i] != 0;  // the root is nobody's child
}
TREELET_HD inline bool is_node_child(const Bvh8Node& node, int i) {
  return !node.child[i].is_leaf() && !node.child[i].is_none();
}
TREELET_HD inline bool is_node_child(const CwbvhNode& node, int i) { return node.is_node(i); }

/// Whether a tree is a single leaf: no other node has one child.
template <class Node>
TREELET_HD bool has_single_child(const Node& node) {
  int children = 0;
  for (int i = 0; i < kChildren<Node>; ++i)
    children += is_leaf_child(node, i) || is_node_child(node, i);
  return children == 1;
}

TREELET_HD inline std::uint32_t node_index(const Bvh2Node& node, int i) { return node.index[i]; }
TREELET_HD inline std::uint32_t node_index(const Bvh8Node& node, int i) {
  return node.child[i].node();
}
TREELET_HD inline std::uint32_t node_index(const CwbvhNode& node, int i) { return node.node(i); }

TREELET_HD inline PositionRange leaf_positions(const Bvh2Node& node, int i) {
  return {node.index[i], node.index[i] + node.count[i]};
}
TREELET_HD inline PositionRange leaf_positions(const Bvh8Node& node, int i) {
  const WideChild child = node.child[i];
  return {child.first_block() * TriangleBlock::kTriangles,
          (child.first_block() + child.block_count()) * TriangleBlock::kTriangles};
}
TREELET_HD inline PositionRange leaf_positions(const CwbvhNode& node, int i) {
  return {node.triangle(i), node.triangle(i) + node.triangle_count(i)};
}

TREELET_HD inline Aabb child_box(const Bvh2Node& node, int i) { return node.box[i]; }
TREELET_HD inline Aabb child_box(const Bvh8Node& node, int i) { return node.box(i); }
TREELET_HD inline Aabb child_box(const CwbvhNode& node, int i) { return decode_box(node, i); }

TREELET_HD inline void set_child_box(Bvh2Node& node, int i, const Aabb& box) { node.box[i] = box; }
TREELET_HD inline void set_child_box(Bvh8Node& node, int i, const Aabb& box) {
  node.set_box(i, box);
}

/// The box of a node, from those of its children.
template <class Node>
TREELET_HD Aabb node_box(const Node& node) {
  Aabb box = child_box(node, 0);
  for (int i = 1; i < kChildren<Node>; ++i) box = merge(box, child_box(node, i));
  return box;
}

/// Positions to an item of the layout.
template <class Item>
inline constexpr std::uint32_t kPositions = 1;
template <>
inline constexpr std::uint32_t kPositions<TriangleBlock> = TriangleBlock::kTriangles;

/// The face at a position; TriangleBlock::kNoFace where there is none.
TREELET_HD inline std::uint32_t& face_at(PackedTriangle* items, std::uint32_t position) {
  return items[position].face;
}
TREELET_HD inline std::uint32_t& face_at(TriangleBlock* items, std::uint32_t position) {
  return items[position / TriangleBlock::kTriangles].face[position % TriangleBlock::kTriangles];
}
TREELET_HD inline std::uint32_t& face_at(CwbvhTriangle* items, std::uint32_t position) {
  return items[position].face;
}

TREELET_HD inline std::uint32_t face_at(const PackedTriangle* items, std::uint32_t position) {
  return items[position].face;
}
TREELET_HD inline std::uint32_t face_at(const CwbvhTriangle* items, std::uint32_t position) {
  return items[position].face;
}
TREELET_HD inline std::uint32_t face_at(const TriangleBlock* items, std::uint32_t position) {
  return items[position / TriangleBlock::kTriangles].face[position % TriangleBlock::kTriangles];
}

TREELET_HD inline Triangle triangle_at(const PackedTriangle* items, std::uint32_t position) {
  return items[position].triangle();
}
TREELET_HD inline Triangle triangle_at(const CwbvhTriangle* items, std::uint32_t position) {
  return items[position].triangle();
}
TREELET_HD inline Triangle triangle_at(const TriangleBlock* items, std::uint32_t position) {
  return items[position / TriangleBlock::kTriangles].triangle(position % TriangleBlock::kTriangles);
}

/// Triangles of a leaf.
TREELET_HD inline std::uint32_t count_triangles(const PackedTriangle*, PositionRange leaf) {
  return leaf.end - leaf.begin;
}
TREELET_HD inline std::uint32_t count_triangles(const CwbvhTriangle*, PositionRange leaf) {
  return leaf.end - leaf.begin;
}
TREELET_HD inline std::uint32_t count_triangles(const TriangleBlock* items, PositionRange leaf) {
  std::uint32_t end = leaf.end;
  while (face_at(items, end - 1) == TriangleBlock::kNoFace) --end;
  return end - leaf.begin;
}

/// Moves the triangle at a position; its face stays.
TREELET_HD inline void set_triangle(PackedTriangle* items, std::uint32_t position,
                                    const Triangle& triangle) {
  PackedTriangle& item = items[position];
  item.p0 = triangle.p0;
  item.p1 = triangle.p1;
  item.p2 = triangle.p2;
}
TREELET_HD inline void set_triangle(CwbvhTriangle* items, std::uint32_t position,
                                    const Triangle& triangle) {
  CwbvhTriangle& item = items[position];
  item.p0 = triangle.p0;
  item.p1 = triangle.p1;
  item.p2 = triangle.p2;
}
TREELET_HD inline void set_triangle(TriangleBlock* items, std::uint32_t position,
                                    const Triangle& triangle) {
  TriangleBlock& block = items[position / TriangleBlock::kTriangles];
  const std::uint32_t lane = position % TriangleBlock::kTriangles;
  const Vec3 corners[3] = {triangle.p0, triangle.p1, triangle.p2};
  for (int corner = 0; corner < 3; ++corner) {
    for (int axis = 0; axis < 3; ++axis) block.vertex[corner][axis][lane] = corners[corner][axis];
  }
}

/// Lanes without a triangle repeat the first of their block; only a leaf's last block has such.
TREELET_HD inline void fill_unused(PackedTriangle*, PositionRange) {}
TREELET_HD inline void fill_unused(CwbvhTriangle*, PositionRange) {}
TREELET_HD inline void fill_unused(TriangleBlock* items, PositionRange leaf) {
  TriangleBlock& block = items[leaf.end / TriangleBlock::kTriangles - 1];
  const Triangle first = block.triangle(0);
  for (std::uint32_t lane = 1; lane < TriangleBlock::kTriangles; ++lane) {
    if (block.face[lane] != TriangleBlock::kNoFace) continue;
    set_triangle(&block, lane, first);
  }
}

}  // namespace treelet
