#pragma once

#include <cstddef>

#include <treelet/layout/cwbvh.h>
#include <treelet/layout/cwbvh_steps.h>
#include <treelet/traverse/scalar_traversal.h>

namespace treelet {

/// Entries that a traversal of this tree may need: seven a level wait while the eighth is visited.
inline std::size_t stack_capacity(const Cwbvh& bvh) {
  return std::size_t(bvh.depth) * (CwbvhNode::kChildren - 1) + 1;
}

/// One ray's way through the compressed layout, a child after the other: the layout is made for
/// devices (traverse/traverse_cwbvh.cuh), and this is what they are tested against.
///
/// A decoded box contains the child's exact one and is rounded outwards to floats, so the slab test
/// of traverse/ray_box.h holds. Its planes may lie outside of the scene by a cell, less than R / 60
/// or 2^-126: by 5u of that the rounding grows, which the padding has room for.
template <class Visitor>
class CwbvhTraversal : public ScalarTraversal<CwbvhTraversal<Visitor>, Cwbvh, Visitor> {
  using Base = ScalarTraversal<CwbvhTraversal, Cwbvh, Visitor>;

 public:
  CwbvhTraversal(const Cwbvh& bvh, const Ray& ray, TraversalStack& stack, Visitor& visitor)
      : Base(bvh, ray, stack, visitor), nearest_slot_(find_nearest_slot(this->box())) {}

  /// In the order that the slots have for the ray's octant.
  bool visit_node(const CwbvhNode& node) {
    typename Base::Entry nodes[CwbvhNode::kChildren];
    int count = 0;
    for (int i = 0; i < CwbvhNode::kChildren; ++i) {
      const int slot = i ^ nearest_slot_;
      if (node.is_none(slot)) continue;
      const BoxSpan span = this->meet(decode_box(node, slot));
      if (!span.is_hit()) continue;
      if (node.is_node(slot)) {
        nodes[count++] = {node.node(slot), span.enter};
      } else if (this->visit_leaf(node.triangle(slot), node.triangle_count(slot))) {
        return false;
      }
    }
    this->push(nodes, count);
    return true;
  }

 private:
  static int find_nearest_slot(const RayBox& box) {
    return box.points_down[0] | box.points_down[1] << 1 | box.points_down[2] << 2;
  }

  const int nearest_slot_;
};

/// Shows the visitor every hit it might want, nearer ones first as far as slots tell.
template <class Visitor>
void traverse(const Cwbvh& bvh, const Ray& ray, TraversalStack& stack, Visitor& visitor) {
  if (bvh.nodes.empty() || !is_traceable(ray)) return;
  CwbvhTraversal<Visitor>(bvh, ray, stack, visitor).run();
}

}  // namespace treelet
