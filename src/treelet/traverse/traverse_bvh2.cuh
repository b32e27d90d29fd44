#pragma once

#include <cstdint>

#include <treelet/layout/device_layout.h>
#include <treelet/traverse/device_stack.h>
#include <treelet/traverse/is_traceable.h>
#include <treelet/core/launch.cuh>
#include <treelet/traverse/device_ray.cuh>

namespace treelet::cuda {

/// One thread's ray through the binary layout: nearer children first, farther ones on a stack in
/// local memory [AilaLaine2009]. Differs: a leaf is visited as soon as its node is, since on
/// processors with a program counter a thread postponing it gains little.
template <class Visitor>
class Bvh2Traversal {
 public:
  __device__ Bvh2Traversal(const DeviceBvh2& bvh, const Ray& ray, StackEntry* stack,
                           Visitor& visitor)
      : bvh_(bvh), ray_(ray, bvh.summary->bounds, visitor), stack_(stack) {}

  __device__ void run() {
    std::uint32_t node = 0;
    do {
      if (!visit_node(node)) return;
    } while (pop(node));
  }

 private:
  /// False when the visitor is done.
  __device__ bool visit_node(std::uint32_t index) {
    ray_.count_node();
    const Bvh2Node node = load_node(index);
    const BoxSpan span[2] = {ray_.intersect(node.box[0]), ray_.intersect(node.box[1])};
    const int nearer = span[1].enter < span[0].enter;
    return (nearer == 0 ? visit_children<0>(node, span) : visit_children<1>(node, span));
  }

  template <int kNearer>
  __device__ bool visit_children(const Bvh2Node& node, const BoxSpan (&span)[2]) {
    constexpr int kFarther = 1 - kNearer;
    if (!visit_if_leaf<kNearer>(node, span) || !visit_if_leaf<kFarther>(node, span)) return false;
    push_if_internal<kFarther>(node, span);
    push_if_internal<kNearer>(node, span);
    return true;
  }

  template <int kChild>
  __device__ bool visit_if_leaf(const Bvh2Node& node, const BoxSpan (&span)[2]) {
    if (!node.is_leaf(kChild) || !span[kChild].is_hit() || span[kChild].enter > ray_.limit()) {
      return true;
    }
    const std::uint32_t end = node.index[kChild] + node.count[kChild];
    for (std::uint32_t i = node.index[kChild]; i < end; ++i) {
      ray_.count_triangles(1);
      const PackedTriangle packed = bvh_.items[i];
      if (ray_.visit(packed.triangle(), packed.face)) return false;
    }
    return true;
  }

  template <int kChild>
  __device__ void push_if_internal(const Bvh2Node& node, const BoxSpan (&span)[2]) {
    if (node.is_leaf(kChild) || node.is_none(kChild) || !span[kChild].is_hit()) return;
    stack_[size_++] = {node.index[kChild], span[kChild].enter};
  }

  /// Pops until a node begins before the limit, or at it: it may hold an equal t of a smaller face.
  __device__ bool pop(std::uint32_t& node) {
    while (size_ > 0) {
      const StackEntry entry = stack_[--size_];
      if (entry.enter <= ray_.limit()) {
        node = entry.node;
        return true;
      }
    }
    return false;
  }

  /// A node is half a 128-byte line: four loads of 16 bytes.
  __device__ Bvh2Node load_node(std::uint32_t index) const {
    Bvh2Node node;
    const float4* from = reinterpret_cast<const float4*>(bvh_.nodes + index);
    float4* to = reinterpret_cast<float4*>(&node);
    for (int i = 0; i < 4; ++i) to[i] = __ldg(from + i);
    return node;
  }

  const DeviceBvh2& bvh_;
  DeviceRay<Visitor> ray_;
  StackEntry* const stack_;
  int size_ = 0;
};

template <class Visitor>
__device__ void traverse(const DeviceBvh2& bvh, const Ray& ray, StackEntry* stack,
                         Visitor& visitor) {
  if (bvh.summary->size.nodes == 0 || !is_traceable(ray)) return;
  Bvh2Traversal<Visitor>(bvh, ray, stack, visitor).run();
}

}  // namespace treelet::cuda
