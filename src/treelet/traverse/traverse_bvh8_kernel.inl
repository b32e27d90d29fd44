// Traversal of the wide layout: a ray against eight boxes, then against the triangles of two blocks
// at once, many rays in turns. See core/lanes.inl for how this is included and what it must not
// call.

#include <treelet/traverse/ray_box.h>
#include <treelet/traverse/ray_box_steps.h>
#include <treelet/traverse/ray_triangle.h>
#include <treelet/traverse/ray_triangle_steps.h>
#include <treelet/traverse/traverse_bvh8.h>
#include <treelet/core/lanes.inl>
#include <treelet/traverse/traverse_bvh8_blocks.inl>
#include <treelet/traverse/traverse_bvh8_boxes.inl>
#include <treelet/traverse/traverse_bvh8_exact.inl>
#include <treelet/traverse/traverse_bvh8_ray.inl>

namespace treelet::TREELET_ISA {
namespace {

/// Numbers of the rays of a wave that wait for the same kind of child. Once more than there are
/// rays: the place after the last is written in vain.
struct Queue {
  std::uint32_t rays[kWaveRays + 1];
  unsigned count = 0;
};

/// Where children of a kind lie: nodes, or blocks of leaves.
struct ChildKind {
  const char* first;
  std::uint32_t index_bits, size;

  TREELET_INLINE const char* at(WideChild child) const {
    return first + std::size_t(child.bits & index_bits) * size;
  }
};

/// What is looked for; an answer of it for every ray.
template <class V, class A>
struct Query {
  using Visitor = V;
  using Answer = A;
};
struct ClosestQuery : Query<ClosestHit<>, Hit> {
  static constexpr bool kAny = false;
  static TREELET_INLINE Hit answer(const Visitor& visitor) { return visitor.hit; }
};
struct AnyQuery : Query<AnyHit, bool> {
  static constexpr bool kAny = true;
  static TREELET_INLINE bool answer(const Visitor& visitor) { return visitor.found; }
};
struct WorkQuery : Query<ClosestHit<Counting>, Work> {
  static constexpr bool kAny = false;
  static TREELET_INLINE Work answer(const Visitor& visitor) { return visitor.work; }
};

/// Rays that are traced in turns. In its turn a ray visits one child, a node or the blocks of a
/// leaf, and the next child is fetched until its next turn. No turn depends on the one before, and
/// one queue for nodes and one for leaves leave the processor nothing to guess.
template <class Query>
class Wave {
  using Answer = typename Query::Answer;
  using RayState = WaveRay<typename Query::Visitor>;

 public:
  TREELET_INLINE Wave(const Bvh8View& bvh, const Ray* rays, std::size_t count, Answer* answers)
      : bvh_(bvh), scene_(bvh.bounds), source_(rays), count_(count), answers_(answers) {}

  TREELET_INLINE void run(const WaveStacks::View& stacks) {
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
  }

 private:
  TREELET_INLINE void visit_nodes() {
    const unsigned count = nodes_.count;
    unsigned nodes = 0, leaves = leaves_.count;
    for (unsigned k = 0; k < count; ++k) {
      const std::uint32_t i = nodes_.rays[k];
      RayState& ray = rays_[i];
      ray.visitor.count_node();
      const ChildStack top{ray.stack.keys + ray.size, ray.stack.children + ray.size};
      ray.size += push_children<!Query::kAny>(ray.slabs, bvh_.nodes[ray.child.node()], top);
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
      if (visit_leaf(rays_[i])) rays_[i].size = 1;
      queue_next(i, nodes, leaves);
    }
    nodes_.count = nodes;
    leaves_.count = leaves;
  }

  /// Pops the ray's next child, or ends the ray and starts another.
  TREELET_INLINE void queue_next(std::uint32_t i, unsigned& nodes, unsigned& leaves) {
    RayState& ray = rays_[i];
    const WideChild child{ray.stack.children[--ray.size]};
    if (child.is_none()) {
      answers_[ray.number] = Query::answer(ray.visitor);
      return start_next(i, nodes);
    }
    ray.child = child;
    const unsigned is_leaf = child.bits >> 31;
    const char* const memory = kinds_[is_leaf].at(child);
    for (unsigned offset = 0; offset < sizeof(Bvh8Node); offset += 64) {
      __builtin_prefetch(memory + offset);
    }
    leaves_.rays[leaves] = i;
    leaves += is_leaf;
    nodes_.rays[nodes] = i;
    nodes += 1 - is_leaf;
  }

  TREELET_INLINE void start_next(std::uint32_t i, unsigned& nodes) {
    RayState& ray = rays_[i];
    while (next_ != count_) {
      ray.number = next_++;
      if (ray.set_up(source_[ray.number], scene_)) {
        ray.child = WideChild::node(0);
        ray.size = 1;
        nodes_.rays[nodes++] = i;
        return;
      }
      answers_[ray.number] = Answer{};
    }
  }

  /// True when the visitor is done.
  TREELET_INLINE bool visit_leaf(RayState& ray) {
    const TriangleBlock* const blocks = bvh_.blocks + ray.child.first_block();
    const unsigned count = ray.child.block_count();
    for (unsigned i = 0; i < count; i += kBlocks) {
      const unsigned second = i + kBlocks <= count ? i + kBlocks - 1 : i;
      const BlockPair pair{blocks + i, blocks + second};
      const unsigned lanes = pair.used_lanes();
      ray.visitor.count_triangles(unsigned(__builtin_popcount(lanes)));
      const Verdict verdict = test_triangles(ray.shear, pair, lanes);
      if (verdict.possible != 0 && visit_candidates(ray, pair, verdict)) return true;
    }
    return false;
  }

  static TREELET_INLINE bool visit_candidates(RayState& ray, const BlockPair& pair,
                                              Verdict verdict) {
    if constexpr (Query::kAny) {
      ray.visitor.found = verdict.certain != 0;
      if (ray.visitor.found) return true;
    }
    const float limit = ray.visitor.t_limit();
    const TriangleBlock* const blocks[2] = {pair.first, pair.second};
    for (int i = 0; i < kBlocks; ++i) {
      const unsigned lanes = verdict.possible >> (4 * i) & 0xf;
      if (lanes != 0 && visit_block(ray, *blocks[i], lanes)) return true;
    }
    if (ray.visitor.t_limit() != limit) ray.update_limit();
    return false;
  }

  static TREELET_INLINE bool visit_block(RayState& ray, const TriangleBlock& block,
                                         unsigned lanes) {
    const BlockHits hits = intersect_in_doubles(ray.shear, block);
    for (unsigned mask = hits.met & lanes; mask != 0; mask &= mask - 1) {
      const int i = __builtin_ctz(mask);
      if (ray.visitor.visit(block.face[i], {hits.t[i], hits.u[i], hits.v[i]})) return true;
    }
    for (unsigned mask = hits.unsure & lanes; mask != 0; mask &= mask - 1) {
      const int i = __builtin_ctz(mask);
      TriangleHit hit;
      if (intersect_exactly(ray.shear, block, i, hit) && ray.visitor.visit(block.face[i], hit)) {
        return true;
      }
    }
    return false;
  }

  const Bvh8View& bvh_;
  const SceneLanes scene_;
  const ChildKind kinds_[2] = {
      {reinterpret_cast<const char*>(bvh_.nodes), ~WideChild::kLeafBit, sizeof(Bvh8Node)},
      {reinterpret_cast<const char*>(bvh_.blocks), WideChild::kMaxBlockIndex,
       sizeof(TriangleBlock)}};
  const Ray* const source_;
  const std::size_t count_;
  Answer* const answers_;
  std::uint32_t next_ = 0;
  Queue nodes_, leaves_;
  RayState rays_[kWaveRays];
};

template <class Query>
void trace(const Bvh8View& bvh, const Ray* rays, std::size_t count, typename Query::Answer* answers,
           const WaveStacks::View& stacks) {
  Wave<Query>(bvh, rays, count, answers).run(stacks);
}

}  // namespace

Bvh8Tracer bvh8_tracer() { return {trace<ClosestQuery>, trace<AnyQuery>, trace<WorkQuery>}; }

}  // namespace treelet::TREELET_ISA
