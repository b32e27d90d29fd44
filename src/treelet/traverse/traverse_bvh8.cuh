#pragma once

#include <cstdint>

#include <treelet/layout/device_layout.h>
#include <treelet/traverse/device_stack.h>
#include <treelet/traverse/is_traceable.h>
#include <treelet/core/launch.cuh>
#include <treelet/traverse/device_ray.cuh>

namespace treelet::cuda {

/// One thread's ray through the CPU's wide layout: for trees that were moved to the device as they
/// are. Its nodes of 256 bytes are made for SIMD; what is built here takes another layout.
template <class Visitor>
class Bvh8Traversal {
 public:
  __device__ Bvh8Traversal(const DeviceBvh8& bvh, const Ray& ray, StackEntry* stack,
                           Visitor& visitor)
      : bvh_(bvh), ray_(ray, bvh.summary->bounds, visitor), stack_(stack) {}

  __device__ void run() {
    push({WideChild::kNone, -INFINITY});  // the root has the number of no child
    while (size_ > 0) {
      const StackEntry entry = stack_[--size_];
      if (entry.enter > ray_.limit()) continue;
      const WideChild child{entry.node};
      if (!child.is_leaf()) {
        push_children(bvh_.nodes[child.node()]);
      } else if (!visit_leaf(child)) {
        return;
      }
    }
  }

 private:
  __device__ void push(StackEntry entry) { stack_[size_++] = entry; }

  /// Pushes the children that are met, the nearest last.
  __device__ void push_children(const Bvh8Node& node) {
    ray_.count_node();
    const int first = size_;
    for (int i = 0; i < Bvh8Node::kChildren; ++i) {
      const WideChild child = node.child[i];
      if (child.is_none()) break;
      const BoxSpan span = ray_.intersect(node.box(i));
      if (!span.is_hit()) continue;
      int place = size_++;
      for (; place > first && stack_[place - 1].enter < span.enter; --place) {
        stack_[place] = stack_[place - 1];
      }
      stack_[place] = {child.bits, span.enter};
    }
  }

  /// False when the visitor is done.
  __device__ bool visit_leaf(WideChild leaf) {
    const TriangleBlock* block = bvh_.items + leaf.first_block();
    const TriangleBlock* const end = block + leaf.block_count();
    for (; block != end; ++block) {
      for (std::uint32_t lane = 0; lane < TriangleBlock::kTriangles; ++lane) {
        if (block->face[lane] == TriangleBlock::kNoFace) break;  // unused lanes come last
        ray_.count_triangles(1);
        if (ray_.visit(block->triangle(lane), block->face[lane])) return false;
      }
    }
    return true;
  }

  const DeviceBvh8& bvh_;
  DeviceRay<Visitor> ray_;
  StackEntry* const stack_;
  int size_ = 0;
};

template <class Visitor>
__device__ void traverse(const DeviceBvh8& bvh, const Ray& ray, StackEntry* stack,
                         Visitor& visitor) {
  if (bvh.summary->size.nodes == 0 || !is_traceable(ray)) return;
  Bvh8Traversal<Visitor>(bvh, ray, stack, visitor).run();
}

}  // namespace treelet::cuda
