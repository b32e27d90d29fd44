// Traversal of the wide layout: a ray against eight boxes, then against four triangles at once. See
// core/lanes.inl for how this is included and what it must not call.

#include <treelet/traverse/ray_box.h>
#include <treelet/traverse/ray_triangle.h>
#include <treelet/traverse/traverse_bvh8.h>
#include <treelet/core/lanes.inl>

namespace treelet::TREELET_ISA {
namespace {

constexpr int kWidth = Bvh8Node::kChildren;
constexpr int kBoxLanes = kNativeLanes < kWidth ? kNativeLanes : kWidth;
using BoxLanes = Lanes<kBoxLanes>;
using TriangleLanes = Lanes<int(TriangleBlock::kTriangles)>;

TREELET_INLINE int lowest_bit(unsigned mask) { return __builtin_ctz(mask); }

TREELET_INLINE void prefetch(const void* begin, unsigned bytes) {
  for (unsigned offset = 0; offset < bytes; offset += 64) {
    __builtin_prefetch(static_cast<const char*>(begin) + offset);
  }
}

/// RayBox, broadcast to lanes; the slab test and its proof are those of traverse/ray_box.h.
struct WideRayBox {
  BoxLanes origin[3], inverse[3], padding[3], t_min;
  int near_row[3], far_row[3];  // of a node's planes

  TREELET_INLINE WideRayBox(const RayBox& ray, float slab_t_min)
      : t_min(broadcast<BoxLanes>(slab_t_min)) {
    for (int axis = 0; axis < 3; ++axis) {
      origin[axis] = broadcast<BoxLanes>(ray.origin[axis]);
      inverse[axis] = broadcast<BoxLanes>(ray.inverse[axis]);
      padding[axis] = broadcast<BoxLanes>(ray.padding[axis]);
      const bool down = ray.points_down[axis];
      near_row[axis] = down ? axis + 3 : axis;
      far_row[axis] = down ? axis : axis + 3;
    }
  }

  /// Bit i: child i is met before the limit. Writes where each is entered.
  TREELET_INLINE unsigned intersect(const Bvh8Node& node, float limit, float* entered) const {
    unsigned mask = 0;
    for (int lane = 0; lane < kWidth; lane += kBoxLanes) {
      BoxLanes enter = t_min, leave = broadcast<BoxLanes>(limit);
      for (int axis = 0; axis < 3; ++axis) {
        const BoxLanes near_plane = load<BoxLanes>(node.planes[near_row[axis]] + lane);
        const BoxLanes far_plane = load<BoxLanes>(node.planes[far_row[axis]] + lane);
        enter = max(enter, (near_plane - origin[axis]) * inverse[axis] - padding[axis]);
        leave = min(leave, (far_plane - origin[axis]) * inverse[axis] + padding[axis]);
      }
      store(entered + lane, enter);
      mask |= at_most_mask(enter, leave) << lane;
    }
    return mask;
  }
};

/// RayShear, broadcast to lanes; may_intersect and its proof are those of traverse/ray_triangle.h.
struct WideRayShear {
  TriangleLanes origin[3], shear_x, shear_y;  // origin by permuted axis
  int axis[3];

  TREELET_INLINE explicit WideRayShear(const RayShear& ray)
      : shear_x(broadcast<TriangleLanes>(ray.shear_x)),
        shear_y(broadcast<TriangleLanes>(ray.shear_y)) {
    const float origin_xyz[3] = {ray.origin.x, ray.origin.y, ray.origin.z};
    for (int i = 0; i < 3; ++i) {
      axis[i] = ray.axis[i];
      origin[i] = broadcast<TriangleLanes>(origin_xyz[axis[i]]);
    }
  }

  struct Vertex {
    TriangleLanes x, y, z;
  };

  TREELET_INLINE Vertex shear(const TriangleBlock& block, int corner) const {
    const auto coordinate = [&](int i) {
      return load<TriangleLanes>(block.vertex[corner][axis[i]]) - origin[i];
    };
    const TriangleLanes z = coordinate(2);
    return {coordinate(0) - shear_x * z, coordinate(1) - shear_y * z, z};
  }

  /// Bit i: triangle i cannot be ruled out.
  TREELET_INLINE unsigned may_intersect(const TriangleBlock& block) const {
    const Vertex a = shear(block, 0), b = shear(block, 1), c = shear(block, 2);
    const TriangleLanes u = c.x * b.y - c.y * b.x;
    const TriangleLanes v = a.x * c.y - a.y * c.x;
    const TriangleLanes w = b.x * a.y - b.y * a.x;
    const TriangleLanes m = max(max(larger(a.x, a.y), larger(b.x, b.y)), larger(c.x, c.y));
    const TriangleLanes z = max(larger(a.z, b.z), larger(c.z, c.z));
    const TriangleLanes bound = broadcast<TriangleLanes>(kEdgeError) * (m * (m + z)) +
                                broadcast<TriangleLanes>(kSmallestNormal);
    const TriangleLanes least = min(u, min(v, w)), most = max(u, max(v, w));
    // A bit is kept where a bound is NaN, as it is where coordinates overflow.
    const unsigned none_negative = ~less_mask(least, -bound);
    const unsigned none_positive = ~less_mask(bound, most);
    return (none_negative | none_positive) & 0xfu;
  }

 private:
  static TREELET_INLINE TriangleLanes larger(TriangleLanes a, TriangleLanes b) {
    return max(max(a, -a), max(b, -b));
  }
};

template <class Visitor>
class Bvh8Traversal {
 public:
  TREELET_INLINE Bvh8Traversal(const Bvh8View& bvh, const RayBox& box, const RayShear& shear,
                               const Ray& ray, TraversalStack::Entry* stack, Visitor& visitor)
      : nodes_(bvh.nodes),
        blocks_(bvh.blocks),
        box_(box),
        wide_box_(box, box.lower_limit(ray.t_min)),
        shear_(shear),
        wide_shear_(shear),
        visitor_(visitor),
        stack_(stack),
        limit_(box.upper_limit(visitor.t_limit())) {}

  TREELET_INLINE void run() {
    TraversalStack::Entry* top = stack_;
    *top++ = {WideChild::kNone, -__builtin_inff()};  // the root has the number of no child
    while (top != stack_) {
      const TraversalStack::Entry entry = *--top;
      if (entry.enter > limit_) continue;
      const WideChild child{entry.node};
      if (!child.is_leaf()) {
        top = push_children(nodes_[child.node()], top);
      } else if (visit_leaf(child)) {
        return;
      }
    }
  }

 private:
  /// Pushes the children that are met, the nearest last.
  TREELET_INLINE TraversalStack::Entry* push_children(const Bvh8Node& node,
                                                      TraversalStack::Entry* top) {
    visitor_.count_node();
    alignas(64) float entered[kWidth];
    unsigned mask = wide_box_.intersect(node, limit_, entered);
    TraversalStack::Entry* const first = top;
    while (mask != 0) {
      const int i = lowest_bit(mask);
      mask &= mask - 1;
      const WideChild child = node.child[i];
      if (child.is_none()) break;  // met only where NaN clips nothing, and the last ones
      prefetch_child(child);
      TraversalStack::Entry* place = top++;
      for (; place != first && place[-1].enter < entered[i]; --place) *place = place[-1];
      *place = {child.bits, entered[i]};
    }
    return top;
  }

  TREELET_INLINE void prefetch_child(WideChild child) const {
    if (child.is_leaf()) {
      prefetch(blocks_ + child.first_block(), sizeof(TriangleBlock));
    } else {
      prefetch(nodes_ + child.node(), sizeof(Bvh8Node));
    }
  }

  TREELET_INLINE bool visit_leaf(WideChild leaf) {
    const TriangleBlock* block = blocks_ + leaf.first_block();
    const TriangleBlock* const end = block + leaf.block_count();
    for (; block != end; ++block) {
      visitor_.count_triangles(used_lanes(*block));
      for (unsigned mask = wide_shear_.may_intersect(*block); mask != 0; mask &= mask - 1) {
        if (visit_candidate(*block, lowest_bit(mask))) return true;
      }
    }
    return false;
  }

  static TREELET_INLINE unsigned used_lanes(const TriangleBlock& block) {
    unsigned used = 0;
    for (const std::uint32_t face : block.face) used += face != TriangleBlock::kNoFace;
    return used;
  }

  TREELET_INLINE bool visit_candidate(const TriangleBlock& block, int lane) {
    if (block.face[lane] == TriangleBlock::kNoFace) return false;
    const auto& v = block.vertex;
    const Triangle triangle{{v[0][0][lane], v[0][1][lane], v[0][2][lane]},
                            {v[1][0][lane], v[1][1][lane], v[1][2][lane]},
                            {v[2][0][lane], v[2][1][lane], v[2][2][lane]}};
    TriangleHit hit;
    if (!intersect_exactly(shear_, triangle, hit)) return false;
    if (visitor_.visit(block.face[lane], hit)) return true;
    limit_ = box_.upper_limit(visitor_.t_limit());
    return false;
  }

  const Bvh8Node* const nodes_;
  const TriangleBlock* const blocks_;
  const RayBox& box_;
  const WideRayBox wide_box_;
  const RayShear& shear_;
  const WideRayShear wide_shear_;
  Visitor& visitor_;
  TraversalStack::Entry* const stack_;
  float limit_;
};

template <class Visitor>
TREELET_INLINE Visitor trace(const Bvh8View& bvh, const Ray& ray, TraversalStack::Entry* stack) {
  Visitor visitor(ray);
  const RayBox box(ray, bvh.bounds);
  const RayShear shear(ray);
  Bvh8Traversal<Visitor>(bvh, box, shear, ray, stack, visitor).run();
  return visitor;
}

Hit trace_closest(const Bvh8View& bvh, const Ray& ray, TraversalStack::Entry* stack) {
  return trace<ClosestHit<>>(bvh, ray, stack).hit;
}
bool trace_any(const Bvh8View& bvh, const Ray& ray, TraversalStack::Entry* stack) {
  return trace<AnyHit>(bvh, ray, stack).found;
}
Work trace_work(const Bvh8View& bvh, const Ray& ray, TraversalStack::Entry* stack) {
  return trace<ClosestHit<Counting>>(bvh, ray, stack).work;
}

}  // namespace

Bvh8Tracer bvh8_tracer() { return {trace_closest, trace_any, trace_work}; }

}  // namespace treelet::TREELET_ISA
