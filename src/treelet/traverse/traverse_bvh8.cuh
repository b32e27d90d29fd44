#pragma once

#include <cmath>
#include <cstdint>

#include <treelet/layout/device_layout.h>
#include <treelet/traverse/device_stack.h>
#include <treelet/traverse/device_ray.cuh>

namespace treelet::cuda {

/// One thread's ray through the CPU's wide layout: for trees that are there for both. Its nodes of
/// 256 bytes are made for SIMD; the wide layout for devices is the compressed one.
template <class Visitor>
class Bvh8Traversal {
 public:
  __device__ Bvh8Traversal(const DeviceBvh8& bvh, RayMemory<Visitor>& ray, WaitingChild* stack)
      : bvh_(bvh), ray_(ray), stack_(stack) {
    stack_[size_++] = {WideChild::kNone, -INFINITY};  // the root has the number of no child
  }

  __device__ DeviceRay<Visitor>& ray() { return ray_; }

  __device__ bool visit_next() {
    if (size_ == 0) return false;
    const WaitingChild next = stack_[--size_];
    if (next.enter > ray_.limit()) return true;
    const WideChild child{next.node};
    if (child.is_leaf()) {
      lane_ = child.first_block() * TriangleBlock::kTriangles;
      end_ = lane_ + child.block_count() * TriangleBlock::kTriangles;
    } else {
      push_children(bvh_.nodes[child.node()]);
    }
    return true;
  }

  __device__ bool find_candidate(Candidate& candidate) {
    for (; lane_ < end_; ++lane_) {
      const TriangleBlock& block = bvh_.items[lane_ / TriangleBlock::kTriangles];
      const std::uint32_t lane = lane_ % TriangleBlock::kTriangles;
      if (block.face[lane] == TriangleBlock::kNoFace) continue;
      ray_.count_triangle();
      candidate = {block.triangle(lane), block.face[lane]};
      if (!ray_.may_hit(candidate.triangle)) continue;
      ++lane_;
      return true;
    }
    return false;
  }

 private:
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

  const DeviceBvh8& bvh_;
  DeviceRay<Visitor> ray_;
  WaitingChild* const stack_;
  int size_ = 0;
  std::uint32_t lane_ = 0, end_ = 0;  ///< lanes of blocks to be tested, counted over all blocks
};

template <class Visitor>
__device__ void traverse(const DeviceBvh8& bvh, RayMemory<Visitor>& ray, WaitingChild* stack) {
  run(Bvh8Traversal<Visitor>(bvh, ray, stack));
}

}  // namespace treelet::cuda
