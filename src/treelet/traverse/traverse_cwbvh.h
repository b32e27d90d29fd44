#pragma once

#include <cstddef>
#include <cstdint>

#include <treelet/layout/cwbvh.h>
#include <treelet/layout/cwbvh_steps.h>
#include <treelet/traverse/is_traceable.h>
#include <treelet/traverse/ray_box.h>
#include <treelet/traverse/ray_triangle.h>
#include <treelet/traverse/traversal_stack.h>
#include <treelet/traverse/visitors.h>

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
class CwbvhTraversal {
 public:
  CwbvhTraversal(const Cwbvh& bvh, const Ray& ray, TraversalStack& stack, Visitor& visitor)
      : bvh_(bvh),
        box_(ray, bvh.bounds),
        shear_(ray),
        visitor_(visitor),
        stack_(stack.entries()),
        nearest_slot_(box_.points_down[0] | box_.points_down[1] << 1 | box_.points_down[2] << 2),
        t_min_(box_.lower_limit(ray.t_min)),
        t_limit_(box_.upper_limit(visitor.t_limit())) {}

  void run() {
    std::uint32_t node = 0;
    do {
      if (!visit_node(bvh_.nodes[node])) return;
    } while (next_node(node));
  }

 private:
  using Entry = TraversalStack::Entry;

  /// Tests leaves and queues nodes, in the order that the slots have for the ray's octant. False
  /// when the visitor is done.
  bool visit_node(const CwbvhNode& node) {
    visitor_.count_node();
    Entry nodes[CwbvhNode::kChildren];
    int count = 0;
    for (int i = 0; i < CwbvhNode::kChildren; ++i) {
      const int slot = i ^ nearest_slot_;
      if (node.is_none(slot)) continue;
      const BoxSpan span = intersect(box_, decode_box(node, slot), t_min_, t_limit_);
      if (!span.is_hit()) continue;
      if (node.is_node(slot)) {
        nodes[count++] = {node.node(slot), span.enter};
      } else if (visit_leaf(node.triangle(slot), node.triangle_count(slot))) {
        return false;
      }
    }
    while (count > 0) stack_[size_++] = nodes[--count];
    return true;
  }

  bool visit_leaf(std::uint32_t first, std::uint32_t count) {
    for (std::uint32_t i = first; i < first + count; ++i) {
      visitor_.count_triangles(1);
      const CwbvhTriangle& packed = bvh_.triangles[i];
      TriangleHit hit;
      if (!intersect(shear_, packed.triangle(), hit)) continue;
      if (visitor_.visit(packed.face, hit)) return true;
      t_limit_ = box_.upper_limit(visitor_.t_limit());
    }
    return false;
  }

  /// Pops until a node begins before the limit, or at it: it may hold an equal t of a smaller face.
  bool next_node(std::uint32_t& node) {
    while (size_ > 0) {
      const Entry entry = stack_[--size_];
      if (entry.enter <= t_limit_) {
        node = entry.node;
        return true;
      }
    }
    return false;
  }

  const Cwbvh& bvh_;
  const RayBox box_;
  const RayShear shear_;
  Visitor& visitor_;
  Entry* const stack_;
  const int nearest_slot_;
  const float t_min_;
  float t_limit_;
  std::uint32_t size_ = 0;
};

/// Shows the visitor every hit it might want, nearer ones first as far as slots tell.
template <class Visitor>
void traverse(const Cwbvh& bvh, const Ray& ray, TraversalStack& stack, Visitor& visitor) {
  if (bvh.nodes.empty() || !is_traceable(ray)) return;
  CwbvhTraversal<Visitor>(bvh, ray, stack, visitor).run();
}

}  // namespace treelet
