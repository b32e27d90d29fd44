#pragma once

#include <cstdint>

#include <treelet/traverse/is_traceable.h>
#include <treelet/traverse/ray_box.h>
#include <treelet/traverse/ray_triangle.h>
#include <treelet/traverse/traversal_stack.h>
#include <treelet/traverse/visitors.h>

namespace treelet {

/// One ray's way through a layout, a child after the other: nodes wait on a stack until they are
/// visited or lie behind the nearest hit. `Derived` says how a node is visited: `visit_node(node)`
/// tests its leaves, pushes its nodes, and is false when the visitor is done.
template <class Derived, class Layout, class Visitor>
class ScalarTraversal {
 public:
  ScalarTraversal(const Layout& bvh, const Ray& ray, TraversalStack& stack, Visitor& visitor)
      : bvh_(bvh),
        box_(ray, bvh.bounds),
        shear_(ray),
        visitor_(visitor),
        stack_(stack.entries()),
        t_min_(box_.lower_limit(ray.t_min)),
        t_limit_(box_.upper_limit(visitor.t_limit())) {}

  void run() {
    std::uint32_t node = 0;
    do {
      visitor_.count_node();
      if (!static_cast<Derived*>(this)->visit_node(bvh_.nodes[node])) return;
    } while (next_node(node));
  }

 protected:
  using Entry = TraversalStack::Entry;

  const RayBox& box() const { return box_; }
  float t_limit() const { return t_limit_; }

  BoxSpan meet(const Aabb& box) const { return intersect(box_, box, t_min_, t_limit_); }

  /// Nodes in the order in which they are to be visited.
  void push(const Entry* nodes, int count) {
    while (count > 0) stack_[size_++] = nodes[--count];
  }

  /// True when the visitor is done.
  bool visit_leaf(std::uint32_t first, std::uint32_t count) {
    for (std::uint32_t i = first; i < first + count; ++i) {
      visitor_.count_triangles(1);
      const auto& packed = bvh_.triangles[i];
      TriangleHit hit;
      if (!intersect(shear_, packed.triangle(), hit)) continue;
      if constexpr (requires { &Visitor::sees; }) {
        if (!visitor_.sees(packed.face, packed.triangle())) continue;
      }
      if (visitor_.visit(packed.face, hit)) return true;
      t_limit_ = box_.upper_limit(visitor_.t_limit());
    }
    return false;
  }

 private:
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

  const Layout& bvh_;
  const RayBox box_;
  const RayShear shear_;
  Visitor& visitor_;
  Entry* const stack_;
  const float t_min_;
  float t_limit_;
  std::uint32_t size_ = 0;
};

}  // namespace treelet
