#pragma once

#include <cstddef>

#include <treelet/core/isa.h>
#include <treelet/core/ray.h>
#include <treelet/layout/bvh8.h>
#include <treelet/traverse/traversal_stack.h>
#include <treelet/traverse/visitors.h>

namespace treelet {

/// Entries that a traversal of this tree may need: seven a level wait while the eighth is visited.
inline std::size_t stack_capacity(const Bvh8& bvh) {
  return std::size_t(bvh.depth) * (Bvh8Node::kChildren - 1) + 1;
}

/// The tree as kernels see it: plain pointers, for they must call nothing of Array's.
struct Bvh8View {
  const Bvh8Node* nodes;
  const TriangleBlock* blocks;
  Aabb bounds;

  explicit Bvh8View(const Bvh8& bvh)
      : nodes(bvh.nodes.data()), blocks(bvh.blocks.data()), bounds(bvh.bounds) {}
};

/// Traversal of the wide layout as compiled for one instruction set. The tree must have nodes and
/// the ray must be traceable; the answers are the same bits for all.
struct Bvh8Tracer {
  Hit (*closest)(const Bvh8View& bvh, const Ray& ray, TraversalStack::Entry* stack);
  bool (*any)(const Bvh8View& bvh, const Ray& ray, TraversalStack::Entry* stack);
  Work (*work)(const Bvh8View& bvh, const Ray& ray, TraversalStack::Entry* stack);
};

Bvh8Tracer bvh8_tracer(Isa isa);

}  // namespace treelet
