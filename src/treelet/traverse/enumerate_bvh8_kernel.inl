// All crossings of rays through the wide layout, many rays in turns. See core/lanes.inl for how
// this is included and what it must not call.

#include <treelet/traverse/enumerate_bvh8.h>
#include <treelet/traverse/ray_box.h>
#include <treelet/traverse/ray_box_steps.h>
#include <treelet/traverse/ray_triangle.h>
#include <treelet/traverse/ray_triangle_steps.h>
#include <treelet/core/lanes.inl>
#include <treelet/traverse/traverse_bvh8_blocks.inl>
#include <treelet/traverse/traverse_bvh8_boxes.inl>
#include <treelet/traverse/traverse_bvh8_exact.inl>
#include <treelet/traverse/traverse_bvh8_filter.inl>
#include <treelet/traverse/traverse_bvh8_ray.inl>

namespace treelet::TREELET_ISA {
namespace {

/// Limits that no hit changes.
struct FixedLimits {
  float t_max;

  TREELET_INLINE explicit FixedLimits(const Ray& ray) : t_max(ray.t_max) {}
  TREELET_INLINE float t_limit() const { return t_max; }
};

struct RayState : WaveRay<FixedLimits> {
  bool is_t_positive;

  TREELET_INLINE bool begin(const Ray& ray, const SceneLanes& scene) {
    if (!set_up(ray, scene)) return false;
    is_t_positive = ray.t_min >= 0.0f;
    if (ray.t_max > kLargest) limit_z(scene);
    child = WideChild::node(0);
    size = 1;
    return true;
  }

 private:
  static constexpr float kLargest = std::numeric_limits<float>::max();

  /// Floats are never certain of a hit before an infinite limit; before one behind the scene they
  /// are.
  TREELET_INLINE void limit_z(const SceneLanes& scene) {
    float farthest = 0.0f;
    for (int i = 0; i < 3; ++i) {
      const int axis = int(shear.row[i] / sizeof(TriangleBlock::vertex[0][0]));
      const float lower = absolute(scene.lower[axis] - shear.origin[i]);
      const float upper = absolute(scene.upper[axis] - shear.origin[i]);
      const float distance = lower < upper ? upper : lower;
      farthest = farthest < distance ? distance : farthest;
    }
    shear.z_max = 4.0f * farthest;
  }
};

/// Numbers of the rays that wait for the same kind of child, and a place to write in vain.
struct Waiting {
  std::uint32_t rays[kWaveRays + 1];
  unsigned count = 0;
};

/// Where nodes lie, or blocks: looked up, for the processor would guess wrong which a child is.
struct ChildMemory {
  const char* first;
  std::uint32_t index_bits, size;

  TREELET_INLINE const char* at(WideChild child) const {
    return first + std::size_t(child.bits & index_bits) * size;
  }
};

/// Rays in turns, each turn a child, as in traverse_bvh8_kernel.inl: until its next turn, a ray's
/// next child is fetched.
template <class Record>
class Enumeration {
 public:
  TREELET_INLINE Enumeration(const Bvh8View& bvh, const Ray* rays, std::size_t count,
                             HitSink<Record>& sink)
      : bvh_(bvh), scene_(bvh.bounds), source_(rays), count_(count), sink_(sink) {}

  TREELET_INLINE std::size_t run(const WaveStacks::View& stacks) {
    for (std::uint32_t i = 0; i < stacks.rays; ++i) {
      std::uint32_t* const memory = stacks.memory + 2 * i * stacks.stride;
      rays_[i].stack = {reinterpret_cast<std::int32_t*>(memory), memory + stacks.stride};
      rays_[i].stack.keys[0] = 0;
      rays_[i].stack.children[0] = WideChild::kNone;
      start_next(i, nodes_.count);
    }
    while (nodes_.count + leaves_.count != 0) {
      visit_nodes();
      visit_leaves();
    }
    return next_;
  }

 private:
  TREELET_INLINE void visit_nodes() {
    const unsigned count = nodes_.count;
    unsigned nodes = 0, leaves = leaves_.count;
    for (unsigned k = 0; k < count; ++k) {
      const std::uint32_t i = nodes_.rays[k];
      RayState& ray = rays_[i];
      const ChildStack top{ray.stack.keys + ray.size, ray.stack.children + ray.size};
      ray.size += push_children<false>(ray.slabs, bvh_.nodes[ray.child.node()], top);
      queue_next(i, nodes, leaves);
    }
    nodes_.count = nodes;
    leaves_.count = leaves;
  }

  TREELET_INLINE void visit_leaves() {
    const unsigned count = leaves_.count;
    unsigned nodes = nodes_.count, leaves = 0;
    for (unsigned k = 0; k < count; ++k) {
      const std::uint32_t i = leaves_.rays[k];
      visit_leaf(rays_[i]);
      queue_next(i, nodes, leaves);
    }
    nodes_.count = nodes;
    leaves_.count = leaves;
  }

  /// Pops the ray's next child, or ends the ray and starts another.
  TREELET_INLINE void queue_next(std::uint32_t i, unsigned& nodes, unsigned& leaves) {
    RayState& ray = rays_[i];
    const WideChild child{ray.stack.children[--ray.size]};
    if (child.is_none()) return start_next(i, nodes);
    ray.child = child;
    const unsigned is_leaf = child.bits >> 31;
    const char* const memory = children_[is_leaf].at(child);
    for (unsigned offset = 0; offset < sizeof(Bvh8Node); offset += 64) {
      __builtin_prefetch(memory + offset);
    }
    leaves_.rays[leaves] = i;
    leaves += is_leaf;
    nodes_.rays[nodes] = i;
    nodes += 1 - is_leaf;
  }

  TREELET_INLINE void start_next(std::uint32_t i, unsigned& nodes) {
    while (next_ != count_ && !sink_.has_enough()) {
      RayState& ray = rays_[i];
      ray.number = next_++;
      if (!ray.begin(source_[ray.number], scene_)) continue;
      nodes_.rays[nodes++] = i;
      return;
    }
  }

  TREELET_INLINE void visit_leaf(const RayState& ray) {
    const TriangleBlock* const blocks = bvh_.blocks + ray.child.first_block();
    const unsigned count = ray.child.block_count();
    for (unsigned i = 0; i < count; i += kBlocks) {
      const unsigned second = i + kBlocks <= count ? i + kBlocks - 1 : i;
      const BlockPair pair{blocks + i, blocks + second};
      Verdict verdict = test_triangles(ray.shear, pair, pair.used_lanes());
      if (verdict.possible == 0) continue;
      if (!bvh_.filter.is_open()) [[unlikely]]
        drop_hidden(bvh_.filter, ray.shear, pair, verdict);
      const TriangleBlock* const tested[2] = {pair.first, pair.second};
      for (int k = 0; k < kBlocks; ++k) {
        const unsigned possible = verdict.possible >> (4 * k) & 0xf;
        if (possible != 0) visit_block(ray, *tested[k], possible, verdict.certain >> (4 * k));
      }
    }
  }

  /// Certain crossings are strictly inside of the triangle and of the limits.
  TREELET_INLINE void visit_block(const RayState& ray, const TriangleBlock& block,
                                  unsigned possible, unsigned certain) {
    certain &= possible;
    if (certain != 0) certain = push_certain(ray, block, certain, sink_);
    for (unsigned mask = possible & ~certain; mask != 0; mask &= mask - 1) {
      const int i = __builtin_ctz(mask);
      TriangleHit hit;
      if (crosses_within_limits(source_[ray.number], block, unsigned(i), hit)) {
        push(ray, block.face[i], hit, sink_);
      }
    }
  }

  /// Returns which lanes it has pushed.
  static TREELET_INLINE unsigned push_certain(const RayState& ray, const TriangleBlock& block,
                                              unsigned lanes, HitSink<RayFace>& sink) {
    for (unsigned mask = lanes; mask != 0; mask &= mask - 1) {
      push(ray, block.face[__builtin_ctz(mask)], {}, sink);
    }
    return lanes;
  }
  /// Where t may have to be moved to have the right sign, it is left to crosses_within_limits.
  static TREELET_INLINE unsigned push_certain(const RayState& ray, const TriangleBlock& block,
                                              unsigned lanes, HitSink<RayHit>& sink) {
    if (!ray.is_t_positive) return 0;
    const BlockHits hits = intersect_in_doubles(ray.shear, block);
    const unsigned positive = less_mask(Lanes<4>{}, load<Lanes<4>>(hits.t));
    const unsigned pushed = lanes & hits.met & positive;
    for (unsigned mask = pushed; mask != 0; mask &= mask - 1) {
      const int i = __builtin_ctz(mask);
      push(ray, block.face[i], {hits.t[i], hits.u[i], hits.v[i]}, sink);
    }
    return pushed;
  }

  static TREELET_INLINE void push(const RayState& ray, std::uint32_t face, const TriangleHit&,
                                  HitSink<RayFace>& sink) {
    sink.push({ray.number, std::int32_t(face)});
  }
  static TREELET_INLINE void push(const RayState& ray, std::uint32_t face, const TriangleHit& hit,
                                  HitSink<RayHit>& sink) {
    sink.push({ray.number, std::int32_t(face), hit.t, hit.u, hit.v});
  }

  const Bvh8View& bvh_;
  const SceneLanes scene_;
  const ChildMemory children_[2] = {
      {reinterpret_cast<const char*>(bvh_.nodes), ~WideChild::kLeafBit, sizeof(Bvh8Node)},
      {reinterpret_cast<const char*>(bvh_.blocks), WideChild::kMaxBlockIndex,
       sizeof(TriangleBlock)}};
  const Ray* const source_;
  const std::size_t count_;
  HitSink<Record>& sink_;
  std::uint32_t next_ = 0;
  Waiting nodes_, leaves_;
  RayState rays_[kWaveRays];
};

template <class Record>
std::size_t enumerate(const Bvh8View& bvh, const Ray* rays, std::size_t count,
                      HitSink<Record>& sink, const WaveStacks::View& stacks) {
  return Enumeration<Record>(bvh, rays, count, sink).run(stacks);
}

}  // namespace

Bvh8Enumerator bvh8_enumerator() { return {enumerate<RayHit>, enumerate<RayFace>}; }

}  // namespace treelet::TREELET_ISA
