// Traversal of the wide layout over triangles in doubles: a ray against eight boxes in floats, then
// against the four triangles of a block in doubles. See core/lanes.inl for how this is included and
// what it must not call.

#include <treelet/core/double_double.h>
#include <treelet/layout/bvh8.h>
#include <treelet/traverse/double_triangle.h>
#include <treelet/traverse/traverse_double.h>
#include <treelet/core/lanes.inl>
#include <treelet/traverse/traverse_bvh8_boxes.inl>
#include <treelet/traverse/traverse_double_block.inl>
#include <treelet/traverse/traverse_double_visitors.inl>

namespace treelet::TREELET_ISA {
namespace {

/// As WaveRay's, from a RayBox (traverse_bvh8_ray.inl).
TREELET_INLINE RaySlabs make_slabs(const DoubleRaySetup& ray) {
  constexpr float kMovedOrigin = 0x1p-23f;  // 2u
  constexpr std::uint32_t kRow = sizeof(Bvh8Node::planes[0]);
  const DoubleRayBox& box = ray.box;
  RaySlabs slabs;
  for (unsigned axis = 0; axis < 3; ++axis) {
    const bool down = __builtin_signbit(box.inverse[axis]);
    const float moved = box.padding + kMovedOrigin * __builtin_fabsf(box.start[axis]);
    const float shift = down ? -moved : moved;
    slabs.near_origin[axis] = box.start[axis] + shift;
    slabs.far_origin[axis] = box.start[axis] - shift;
    slabs.minus_inverse[axis] = -box.inverse[axis];
    slabs.near_row[axis] = (down ? axis + 3 : axis) * kRow;
    slabs.far_row[axis] = (down ? axis : axis + 3) * kRow;
  }
  slabs.t_min = box.lower_limit(ray.ray->t_min);
  slabs.limit = box.upper_limit(ray.ray->t_max);
  return slabs;
}

/// Shows a ray the leaves on its way, nearest first as far as boxes tell.
template <class Visitor>
TREELET_INLINE void traverse(const DoubleBvh8View& bvh, DoubleRaySetup& ray, Visitor visitor) {
  RaySlabs slabs = make_slabs(ray);
  const auto visit_leaf = [&](WideChild leaf) __attribute__((always_inline)) {
    const DoubleBlock* const blocks = bvh.blocks + leaf.first_block();
    for (unsigned i = 0; i < leaf.block_count(); ++i) {
      const DoubleVerdict verdict = test_block(ray, blocks[i]);
      if (verdict.possible != 0 && visitor.visit(ray, blocks[i], verdict)) return true;
    }
    if constexpr (Visitor::kMovesLimit) slabs.limit = ray.box.upper_limit(visitor.limit());
    return false;
  };
  WideChild child = WideChild::node(0);
  std::uint32_t size = 0;
  while (true) {
    if (!child.is_leaf()) {
      const ChildStack top{bvh.keys + size, bvh.children + size};
      size += push_children<true>(slabs, bvh.nodes[child.node()], top);
    } else if (visit_leaf(child)) {
      break;
    }
    const std::int32_t last = key_of(slabs.limit) | kPlaceBits;
    do {
      if (size == 0) return visitor.finish(ray);
      --size;
    } while (bvh.keys[size] > last);
    child = {bvh.children[size]};
  }
  visitor.finish(ray);
}

void find_closest(const DoubleBvh8View& bvh, DoubleRaySetup& ray, DoubleHit& hit) {
  traverse(bvh, ray, DoubleClosest(ray, hit));
}
void find_any(const DoubleBvh8View& bvh, DoubleRaySetup& ray, bool& found) {
  traverse(bvh, ray, DoubleAny(found));
}
void count_all(const DoubleBvh8View& bvh, DoubleRaySetup& ray, std::int64_t& count) {
  traverse(bvh, ray, DoubleCount(count));
}
void list_all(const DoubleBvh8View& bvh, DoubleRaySetup& ray, std::vector<DoubleHit>& hits) {
  traverse(bvh, ray, DoubleList(hits));
}

}  // namespace

DoubleTracer double_tracer() { return {find_closest, find_any, count_all, list_all}; }

}  // namespace treelet::TREELET_ISA
