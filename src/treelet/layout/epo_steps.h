#pragma once

#include <cstdint>

#include <treelet/layout/clip.h>
#include <treelet/layout/layout_access.h>
#include <treelet/tree/sah.h>

// What one face does in the end-point overlap (layout/epo.h); host and device loop over it and add
// in the same order.

namespace treelet {

/// What there is to know about the subtree of a node without reading it.
struct EpoSubtree {
  static constexpr std::uint32_t kNone = 0xffffffff;
  static constexpr std::uint32_t kParent = 0x80000000;

  Aabb box;             ///< that the parent holds; of no meaning for the root
  std::uint32_t first;  ///< the first child that is a node
  std::uint32_t next;   ///< the next such child of the parent; of the last one, kParent | parent
  PositionRange range;  ///< its positions, which are one run
};

/// Writes what a node knows about its children, and its own `first`; the root's `next` is nobody's.
template <class Node>
TREELET_HD void link_children(const Node* nodes, std::uint32_t index, EpoSubtree* subtrees) {
  const Node& node = nodes[index];
  if (index == 0) subtrees[0].next = EpoSubtree::kNone;
  std::uint32_t first = EpoSubtree::kNone;
  for (int i = kChildren<Node> - 1; i >= 0; --i) {
    if (!is_node_child(node, i)) continue;
    EpoSubtree& child = subtrees[node_index(node, i)];
    child.box = child_box(node, i);
    child.next = first == EpoSubtree::kNone ? EpoSubtree::kParent | index : first;
    first = node_index(node, i);
  }
  subtrees[index].first = first;
}

struct EpoAreas {
  double overlap = 0.0;  ///< of a surface with nodes that it is not in, weighted by their costs
  double surface = 0.0;
};
TREELET_HD inline EpoAreas operator+(const EpoAreas& a, const EpoAreas& b) {
  return {a.overlap + b.overlap, a.surface + b.surface};
}

/// Faces that make up one partial sum.
constexpr std::uint32_t kEpoGrain = 256;

/// A packed tree as the measure sees it.
template <class Node, class Item>
struct EpoTree {
  const Node* nodes;
  const Item* items;
  const EpoSubtree* subtrees;  ///< by node
  std::uint32_t node_count;
};

/// Walks over a tree, depth first, with one triangle. Does not keep a stack of nodes: each knows
/// the next one.
template <class Node, class Item, class IsAtHome>
class EpoWalk {
 public:
  /// is_at_home(range) says whether the triangle's face is at one of these positions.
  TREELET_HD EpoWalk(const EpoTree<Node, Item>& tree, const SahModel& sah, const Triangle& triangle,
                     const IsAtHome& is_at_home)
      : tree_(tree), sah_(sah), whole_(triangle), bounds_(bounds(triangle)), is_home_(is_at_home) {}

  TREELET_HD EpoAreas run() const {
    EpoAreas areas{0.0, whole_.area()};
    std::uint32_t node = tree_.node_count == 0 ? EpoSubtree::kNone : 0;
    while (node != EpoSubtree::kNone) {
      const EpoSubtree& subtree = tree_.subtrees[node];
      const double area = node == 0 ? 0.0 : foreign_area(subtree.box, subtree.range);
      if (area < 0.0) {
        node = behind(node);
        continue;
      }
      areas.overlap += double(sah_.traversal_cost) * area;
      add_leaves(tree_.nodes[node], areas);
      node = subtree.first == EpoSubtree::kNone ? behind(node) : subtree.first;
    }
    return areas;
  }

 private:
  static constexpr double kOutside = -1.0;

  /// The first node behind a subtree.
  TREELET_HD std::uint32_t behind(std::uint32_t node) const {
    std::uint32_t next = tree_.subtrees[node].next;
    while (next != EpoSubtree::kNone && (next & EpoSubtree::kParent) != 0) {
      next = tree_.subtrees[next & ~EpoSubtree::kParent].next;
    }
    return next;
  }

  TREELET_HD void add_leaves(const Node& node, EpoAreas& areas) const {
    for (int i = 0; i < kChildren<Node>; ++i) {
      if (!is_leaf_child(node, i)) continue;
      const PositionRange range = leaf_positions(node, i);
      const double area = foreign_area(child_box(node, i), range);
      if (area <= 0.0) continue;
      areas.overlap += double(sah_.intersection_cost) * count_triangles(tree_.items, range) * area;
    }
  }

  /// Area of the triangle in a box that is not its own; kOutside where there is not even a point.
  TREELET_HD double foreign_area(const Aabb& box, const PositionRange& range) const {
    if (!overlaps(box)) return kOutside;  // its own boxes all overlap it
    if (is_home_(range)) return 0.0;
    ClippedTriangle polygon = whole_;
    polygon.clip(box);
    return polygon.size == 0 ? kOutside : polygon.area();
  }

  TREELET_HD bool overlaps(const Aabb& box) const {
    return box.lower.x <= bounds_.upper.x && bounds_.lower.x <= box.upper.x &&
           box.lower.y <= bounds_.upper.y && bounds_.lower.y <= box.upper.y &&
           box.lower.z <= bounds_.upper.z && bounds_.lower.z <= box.upper.z;
  }

  const EpoTree<Node, Item>& tree_;
  const SahModel& sah_;
  const ClippedTriangle whole_;
  const Aabb bounds_;
  const IsAtHome& is_home_;
};

}  // namespace treelet
