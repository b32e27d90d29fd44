#pragma once

#include <cmath>
#include <cstdint>

#include <treelet/layout/device_layout.h>
#include <treelet/traverse/device_stack.h>
#include <treelet/traverse/device_ray.cuh>
#include <treelet/traverse/load.cuh>

namespace treelet::cuda {

/// One thread's ray through the binary layout: nearer children first, farther ones on a stack. What
/// is on top of it stays in registers.
template <class Visitor>
class Bvh2Traversal {
 public:
  __device__ Bvh2Traversal(const DeviceBvh2& bvh, RayMemory<Visitor>& ray, WaitingChild* stack)
      : bvh_(bvh), ray_(ray), stack_(stack) {}

  __device__ DeviceRay<Visitor>& ray() { return ray_; }

  __device__ bool visit_next() {
    // A node that begins at the limit may hold an equal t of a smaller face; none begins at NaN.
    while (!(next_.enter <= ray_.limit())) {
      if (size_ == 0) return false;
      next_ = stack_[--size_];
    }
    visit_node(load_by<uint4>(bvh_.nodes + next_.node));
    return true;
  }

  __device__ bool find_candidate(Candidate& candidate) {
    while (triangle_ != end_) {
      ray_.count_triangle();
      const PackedTriangle packed = load_by<uint2>(bvh_.items + triangle_++);
      candidate = {packed.triangle(), packed.face};
      if (ray_.may_hit(candidate.triangle)) return true;
    }
    return false;
  }

 private:
  __device__ void visit_node(const Bvh2Node& node) {
    ray_.count_node();
    const BoxSpan span[2] = {ray_.intersect(node.box[0]), ray_.intersect(node.box[1])};
    const bool is_hit[2] = {span[0].is_hit(), span[1].is_hit()};
    // Two leaves of one node are neighbours: their triangles are one run.
    const std::uint32_t count[2] = {is_hit[0] ? node.count[0] : 0, is_hit[1] ? node.count[1] : 0};
    triangle_ = count[0] > 0 ? node.index[0] : node.index[1];
    end_ = triangle_ + count[0] + count[1];

    const WaitingChild none{0, NAN};
    const WaitingChild child[2] = {{node.index[0], span[0].enter}, {node.index[1], span[1].enter}};
    const bool goes_on[2] = {is_hit[0] && node.count[0] == 0, is_hit[1] && node.count[1] == 0};
    const bool swapped = goes_on[1] && !(goes_on[0] && span[0].enter <= span[1].enter);
    if (goes_on[0] && goes_on[1]) stack_[size_++] = swapped ? child[0] : child[1];
    next_ = swapped ? child[1] : goes_on[0] ? child[0] : none;
  }

  const DeviceBvh2& bvh_;
  DeviceRay<Visitor> ray_;
  WaitingChild* const stack_;
  std::uint32_t size_ = 0;
  WaitingChild next_{0, -INFINITY};       ///< first the root
  std::uint32_t triangle_ = 0, end_ = 0;  ///< to be tested
};

template <class Visitor>
__device__ void traverse(const DeviceBvh2& bvh, RayMemory<Visitor>& ray, WaitingChild* stack) {
  run(Bvh2Traversal<Visitor>(bvh, ray, stack));
}

}  // namespace treelet::cuda
