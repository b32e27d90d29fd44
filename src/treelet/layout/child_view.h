#pragma once

#include <cstddef>
#include <cstdint>

#include <treelet/layout/bvh2.h>
#include <treelet/layout/bvh8.h>
#include <treelet/layout/cwbvh.h>
#include <treelet/layout/layout_access.h>
#include <treelet/tree/sah.h>

// One way to read all layouts, for what need not be fast: statistics and validation.
//
// A position numbers the places for triangles in leaf order. The wide layout has places without a
// triangle.

namespace treelet {

/// A child of a node: a node below, or a leaf with positions [begin, end).
struct ChildView {
  Aabb box;
  bool is_leaf;
  std::uint32_t node;
  std::size_t begin, end;
};

constexpr int children_per_node(const Bvh2&) { return 2; }
constexpr int children_per_node(const Bvh8&) { return Bvh8Node::kChildren; }
constexpr int children_per_node(const Cwbvh&) { return CwbvhNode::kChildren; }

/// Unused children have empty boxes and are no leaves.
inline ChildView child_of(const Bvh2& bvh, std::uint32_t node, int child) {
  const Bvh2Node& n = bvh.nodes[node];
  const std::size_t begin = n.index[child];
  return {n.box[child], n.is_leaf(child), n.index[child], begin, begin + n.count[child]};
}
inline ChildView child_of(const Bvh8& bvh, std::uint32_t node, int child) {
  const Bvh8Node& n = bvh.nodes[node];
  const WideChild c = n.child[child];
  if (!c.is_leaf()) return {n.box(child), false, c.node(), 0, 0};
  const std::size_t begin = std::size_t(c.first_block()) * TriangleBlock::kTriangles;
  return {n.box(child), true, 0, begin, begin + c.block_count() * TriangleBlock::kTriangles};
}
/// The box is the one that the planes bound.
inline ChildView child_of(const Cwbvh& bvh, std::uint32_t node, int child) {
  const CwbvhNode& n = bvh.nodes[node];
  if (!n.is_leaf(child)) return {child_box(n, child), false, n.node(child), 0, 0};
  const PositionRange leaf = leaf_positions(n, child);
  return {child_box(n, child), true, 0, leaf.begin, leaf.end};
}

inline std::size_t position_count(const Bvh2& bvh) { return bvh.triangles.size(); }
inline std::size_t position_count(const Bvh8& bvh) {
  return bvh.blocks.size() * TriangleBlock::kTriangles;
}
inline std::size_t position_count(const Cwbvh& bvh) { return bvh.triangles.size(); }

/// The face at a position; TriangleBlock::kNoFace where there is none.
inline std::uint32_t face_at(const Bvh2& bvh, std::size_t position) {
  return bvh.triangles[position].face;
}
inline std::uint32_t face_at(const Cwbvh& bvh, std::size_t position) {
  return bvh.triangles[position].face;
}
inline std::uint32_t face_at(const Bvh8& bvh, std::size_t position) {
  return bvh.blocks[position / TriangleBlock::kTriangles]
      .face[position % TriangleBlock::kTriangles];
}
template <class Layout>
bool has_triangle(const Layout& bvh, std::size_t position) {
  return face_at(bvh, position) != TriangleBlock::kNoFace;
}

inline Triangle triangle_at(const Bvh2& bvh, std::size_t position) {
  return bvh.triangles[position].triangle();
}
inline Triangle triangle_at(const Cwbvh& bvh, std::size_t position) {
  return bvh.triangles[position].triangle();
}
inline Triangle triangle_at(const Bvh8& bvh, std::size_t position) {
  return bvh.blocks[position / TriangleBlock::kTriangles].triangle(
      std::uint32_t(position % TriangleBlock::kTriangles));
}

template <class Layout>
std::uint32_t count_triangles(const Layout& bvh, const ChildView& leaf) {
  std::uint32_t count = 0;
  for (std::size_t i = leaf.begin; i < leaf.end; ++i) count += has_triangle(bvh, i);
  return count;
}

/// The cost of a child itself, without what lies below it, in units of area.
template <class Layout>
double own_weight(const Layout& bvh, const ChildView& child, const SahModel& sah) {
  return child.is_leaf ? double(sah.intersection_cost) * count_triangles(bvh, child)
                       : double(sah.traversal_cost);
}

}  // namespace treelet
