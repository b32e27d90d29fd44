// Coherent rays through the tree together. Part of traverse_bvh8_kernel.inl.
//
// A packet visits what any ray between its own would meet [Reshetov2005]: a node costs it no more
// than a single ray, and triangles are tested against all rays at once. Differs from [Benthin2012],
// who test boxes against each ray: so few boxes are met by the packet and by none of its rays that
// this does not pay. Packets that are too wide for the triangles around them give up instead, and
// their rays go on one by one.

namespace treelet::TREELET_ISA {
namespace {

/// Nodes and triangles that a packet may visit; those that pay take a third.
constexpr int kBudget = 128;

/// Coherent rays on their way through the tree.
template <class Query>
struct alignas(64) Packet : PacketRays {
  using Answer = typename Query::Answer;

  ChildStack stack;
  std::uint32_t size;    ///< of the stack
  WideChild child;       ///< to be visited next
  std::uint32_t number;  ///< of the first ray in the batch
  int budget;            ///< visits that are left
  typename Query::PacketVisitor visitor{RayLanes{}, RayLanes{}};

  TREELET_INLINE bool set_up(const Ray* rays, const SceneLanes& scene, const Answer*) {
    const PacketSource source(rays);
    if (!PacketRays::set_up(source, scene)) return false;
    visitor = typename Query::PacketVisitor(source.t_min, source.t_max);
    budget = kBudget;
    return true;
  }
  TREELET_INLINE void count_node() { --budget; }
  /// False for a packet that gave up: its answers are then what it found so far.
  TREELET_INLINE bool finish(Answer* answers) {
    visitor.write(answers + number);
    return budget > 0 || visitor.open() == 0;
  }

  /// True when nothing is left to look for.
  TREELET_INLINE bool visit_leaf(const TriangleBlock* blocks, unsigned count,
                                 const FaceFilter& filter) {
    bool is_closer = false;
    for (unsigned i = 0; i < count; i += kBlocks) {
      const unsigned second = i + kBlocks <= count ? i + kBlocks - 1 : i;
      const BlockPair pair{blocks + i, blocks + second};
      unsigned near = find_triangles(slabs, pair) & pair.used_lanes();
      budget -= 1 + __builtin_popcount(near);
      for (; near != 0; near &= near - 1) {
        is_closer |= visit_triangle(pair.triangle(__builtin_ctz(near)), filter);
      }
      if (visitor.open() == 0) return true;
    }
    if (is_closer) size = drop_behind(slabs.limit, stack, size);
    return budget <= 0;
  }

 private:
  /// True when that makes a limit smaller.
  TREELET_INLINE bool visit_triangle(BlockTriangle triangle, const FaceFilter& filter) {
    Verdict verdict = test_rays(shear, triangle, visitor.open());
    if constexpr (Query::kFilters) drop_hidden(filter, shear, triangle, verdict);
    if constexpr (Query::kAny) {
      visitor.accept(verdict.certain);
      verdict.possible &= ~verdict.certain;
    }
    if (verdict.possible == 0) return false;
    bool is_closer = false;
    for (int first = 0; first < kPacketRays; first += kExactRays) {
      const unsigned rays = verdict.possible >> first & ((1u << kExactRays) - 1);
      if (rays != 0) is_closer |= visit_candidates(triangle, first, rays);
    }
    if (is_closer) set_limits(visitor.limit);
    return is_closer;
  }

  TREELET_INLINE bool visit_candidates(BlockTriangle triangle, int first, unsigned rays) {
    const auto face = std::int32_t(triangle.face());
    const DoubleHits<RayDoubles> hits = intersect_in_doubles(shear, triangle, first);
    bool is_closer = visitor.visit({first, hits.met & rays, face, round_to<ExactLanes>(hits.t),
                                    round_to<ExactLanes>(hits.u), round_to<ExactLanes>(hits.v)});
    for (unsigned mask = hits.unsure & rays; mask != 0; mask &= mask - 1) {
      const int i = __builtin_ctz(mask);
      TriangleHit hit;
      if (!intersect_exactly(shear_of(shear, first + i), triangle.block, triangle.lane, hit))
        continue;
      is_closer |= visitor.visit({first, 1u << i, face, broadcast<ExactLanes>(hit.t),
                                  broadcast<ExactLanes>(hit.u), broadcast<ExactLanes>(hit.v)});
    }
    return is_closer;
  }
};

}  // namespace
}  // namespace treelet::TREELET_ISA
