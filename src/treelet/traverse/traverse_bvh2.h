#pragma once

#include <cmath>
#include <limits>
#include <utility>

#include <treelet/layout/bvh2.h>
#include <treelet/traverse/is_traceable.h>
#include <treelet/traverse/ray_box.h>
#include <treelet/traverse/ray_triangle.h>
#include <treelet/traverse/traversal_stack.h>
#include <treelet/traverse/visitors.h>

namespace treelet {

/// Entries that a traversal of this tree may need.
inline std::size_t stack_capacity(const Bvh2& bvh) { return bvh.depth; }

/// One ray's way through the binary layout: nearer children first, farther ones on a stack.
template <class Visitor>
class Bvh2Traversal {
 public:
  Bvh2Traversal(const Bvh2& bvh, const Ray& ray, TraversalStack& stack, Visitor& visitor)
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
      if (!visit_node(node)) return;
    } while (next_node(node));
  }

 private:
  using Entry = TraversalStack::Entry;

  /// Tests leaf children and queues internal ones, the nearer on top. False when the visitor is
  /// done.
  bool visit_node(std::uint32_t index) {
    visitor_.count_node();
    const Bvh2Node& node = bvh_.nodes[index];
    const BoxSpan span[2] = {intersect(box_, node.box[0], t_min_, t_limit_),
                             intersect(box_, node.box[1], t_min_, t_limit_)};
    const int nearer = span[1].enter < span[0].enter;
    Entry internal[2];
    int count = 0;
    for (const int child : {nearer, 1 - nearer}) {
      if (!span[child].is_hit() || node.is_none(child)) continue;
      if (!node.is_leaf(child)) {
        internal[count++] = {node.index[child], span[child].enter};
      } else if (span[child].enter <= t_limit_ &&
                 visit_leaf(node.index[child], node.count[child])) {
        return false;
      }
    }
    while (count > 0) stack_[size_++] = internal[--count];
    return true;
  }

  bool visit_leaf(std::uint32_t first, std::uint32_t count) {
    for (std::uint32_t i = first; i < first + count; ++i) {
      visitor_.count_triangles(1);
      const PackedTriangle& packed = bvh_.triangles[i];
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

  const Bvh2& bvh_;
  const RayBox box_;
  const RayShear shear_;
  Visitor& visitor_;
  Entry* const stack_;
  const float t_min_;
  float t_limit_;
  std::uint32_t size_ = 0;
};

/// Shows the visitor every hit it might want, nearer ones first as far as boxes tell.
template <class Visitor>
void traverse(const Bvh2& bvh, const Ray& ray, TraversalStack& stack, Visitor& visitor) {
  if (bvh.nodes.empty() || !is_traceable(ray)) return;
  Bvh2Traversal<Visitor>(bvh, ray, stack, visitor).run();
}

}  // namespace treelet
