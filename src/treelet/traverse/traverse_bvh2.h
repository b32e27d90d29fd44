#pragma once

#include <cstddef>

#include <treelet/layout/bvh2.h>
#include <treelet/traverse/scalar_traversal.h>

namespace treelet {

/// Entries that a traversal of this tree may need.
inline std::size_t stack_capacity(const Bvh2& bvh) { return bvh.depth; }

/// One ray's way through the binary layout: nearer children first, farther ones on a stack.
template <class Visitor>
class Bvh2Traversal : public ScalarTraversal<Bvh2Traversal<Visitor>, Bvh2, Visitor> {
  using Base = ScalarTraversal<Bvh2Traversal, Bvh2, Visitor>;

 public:
  using Base::Base;

  bool visit_node(const Bvh2Node& node) {
    const BoxSpan span[2] = {this->meet(node.box[0]), this->meet(node.box[1])};
    const int nearer = span[1].enter < span[0].enter;
    typename Base::Entry internal[2];
    int count = 0;
    for (const int child : {nearer, 1 - nearer}) {
      if (!span[child].is_hit() || node.is_none(child)) continue;
      if (!node.is_leaf(child)) {
        internal[count++] = {node.index[child], span[child].enter};
      } else if (span[child].enter <= this->t_limit() &&
                 this->visit_leaf(node.index[child], node.count[child])) {
        return false;
      }
    }
    this->push(internal, count);
    return true;
  }
};

/// Shows the visitor every hit it might want, nearer ones first as far as boxes tell.
template <class Visitor>
void traverse(const Bvh2& bvh, const Ray& ray, TraversalStack& stack, Visitor& visitor) {
  if (bvh.nodes.empty() || !is_traceable(ray)) return;
  Bvh2Traversal<Visitor>(bvh, ray, stack, visitor).run();
}

}  // namespace treelet
