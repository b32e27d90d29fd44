#pragma once

#include <cstdint>

#include <treelet/layout/device_layout.h>
#include <treelet/traverse/device_stack.h>
#include <treelet/traverse/device_ray.cuh>
#include <treelet/traverse/grid_slabs.cuh>
#include <treelet/traverse/load.cuh>

namespace treelet::cuda {

/// One thread's ray through the compressed layout [YlitieKarrasLaine2017 s4]: all eight children of
/// a node are tested at once, and what is met of them is one word, in the order of the slots that
/// the ray's octant asks for. Groups of children wait on the stack, without a distance: where the
/// ray has become shorter meanwhile, a node may be visited in vain.
///
/// Differs: triangles are not put off until more threads of the warp have some; that takes votes
/// and a stack of two kinds of groups.
template <class Visitor>
class CwbvhTraversal {
 public:
  __device__ CwbvhTraversal(const DeviceCwbvh& bvh, RayMemory<Visitor>& ray, WaitingGroup* stack)
      : bvh_(bvh), ray_(ray), stack_(stack), nearest_slot_(ray_.slabs().octant()) {}

  __device__ DeviceRay<Visitor>& ray() { return ray_; }

  __device__ bool visit_next() {
    if (!waits(group_)) {
      if (size_ == 0) return false;
      group_ = stack_[--size_];
    }
    const std::uint32_t node = take_nearest();
    if (waits(group_)) stack_[size_++] = group_;
    visit_node(load_by<uint4>(bvh_.nodes + node));
    return true;
  }

  __device__ bool find_candidate(Candidate& candidate) {
    while (triangles_ != 0) {
      ray_.count_triangle();
      const std::uint32_t offset = __ffs(int(triangles_)) - 1;
      triangles_ &= triangles_ - 1;
      const CwbvhTriangle packed = load_by<uint4>(bvh_.items + first_triangle_ + offset);
      candidate = {packed.triangle(), packed.face};
      if (ray_.may_hit(candidate.triangle)) return true;
    }
    return false;
  }

 private:
  static constexpr std::uint32_t kTriangleBits = 0x00ffffff;

  __device__ static bool waits(const WaitingGroup& group) { return group.bits > kTriangleBits; }

  /// Takes the child with the highest bit out of the group: the node that it is.
  __device__ std::uint32_t take_nearest() {
    const std::uint32_t bit = 31 - __clz(int(group_.bits));
    group_.bits &= ~(1u << bit);
    const std::uint32_t slot = (bit - CwbvhNode::kNodeOffset) ^ 7 ^ nearest_slot_;
    return group_.first_node + __popc(group_.bits & ((1u << slot) - 1));
  }

  __device__ void visit_node(const CwbvhNode& node) {
    ray_.count_node();
    const GridSlabs grid(ray_.slabs(), node);
    const std::uint32_t met = meet_four<0>(node, grid) | meet_four<4>(node, grid);
    group_ = {node.first_node, (met & ~kTriangleBits) | node.node_mask};
    first_triangle_ = node.first_triangle;
    triangles_ = met & kTriangleBits;
  }

  /// Tests children kFirst to kFirst + 3. Of a node that is met, bit 24 + (slot ^ farthest slot) is
  /// set; of a leaf, those at the offsets of its triangles. No child has no bits.
  template <int kFirst>
  __device__ std::uint32_t meet_four(const CwbvhNode& node, const GridSlabs& grid) const {
    const FusedSlabs& slabs = ray_.slabs();
    const PlaneWords planes(slabs, node, kFirst);
    const std::uint32_t meta = word_at(&node.meta[kFirst]);
    const std::uint32_t are_nodes = meta >> 4 & meta >> 3 & 0x01010101;  // offsets from 24 on
    const std::uint32_t places = (meta & 0x1f1f1f1f) ^ are_nodes * (7 ^ nearest_slot_);
    const std::uint32_t bits = meta >> 5 & 0x07070707;
    std::uint32_t met = 0;
    for (int i = 0; i < 4; ++i) {
      if (!grid.intersect(slabs, planes, i, ray_.limit()).is_hit()) continue;
      met |= byte_of(bits, i) << byte_of(places, i);
    }
    return met;
  }

  const DeviceCwbvh& bvh_;
  DeviceRay<Visitor> ray_;
  WaitingGroup* const stack_;
  const std::uint32_t nearest_slot_;
  std::uint32_t size_ = 0;
  WaitingGroup group_{0, 1u << 31};  ///< on top of the stack; first the root, alone
  std::uint32_t first_triangle_ = 0, triangles_ = 0;  ///< to be tested, a bit each
};

template <class Visitor>
__device__ void traverse(const DeviceCwbvh& bvh, RayMemory<Visitor>& ray, WaitingGroup* stack) {
  run(CwbvhTraversal<Visitor>(bvh, ray, stack));
}

}  // namespace treelet::cuda
