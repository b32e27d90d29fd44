// A single ray and the leaves that it visits. Part of traverse_bvh8_kernel.inl.

namespace treelet::TREELET_ISA {
namespace {

/// A ray on its way through the tree, by itself.
template <class Query>
struct SingleRay : WaveRay<typename Query::Visitor> {
  static constexpr std::uint32_t kRays = 1;
  using Base = WaveRay<typename Query::Visitor>;
  using Answer = typename Query::Answer;
  using Base::number, Base::shear, Base::visitor;

  /// Goes on from the answer of a packet that gave up. False when nothing is left to look for.
  TREELET_INLINE bool set_up(const Ray* ray, const SceneLanes& scene, const Answer* known) {
    if (!Base::set_up(*ray, scene)) return false;
    if constexpr (Query::kAny) {
      return !*known;
    } else if constexpr (Query::kHasPackets) {
      if (known->face < 0) return true;
      visitor.hit = *known;
      visitor.limit = known->t;
      Base::set_limit();
    }
    return true;
  }
  TREELET_INLINE void count_node() { visitor.count_node(); }
  TREELET_INLINE bool finish(Answer* answers) {
    answers[number] = Query::answer(visitor);
    return true;
  }

  /// True when the visitor is done.
  TREELET_INLINE bool visit_leaf(const TriangleBlock* blocks, unsigned count,
                                 const FaceFilter& filter) {
    for (unsigned i = 0; i < count; i += kBlocks) {
      const unsigned second = i + kBlocks <= count ? i + kBlocks - 1 : i;
      const BlockPair pair{blocks + i, blocks + second};
      const unsigned lanes = pair.used_lanes();
      visitor.count_triangles(unsigned(__builtin_popcount(lanes)));
      Verdict verdict = test_triangles(shear, pair, lanes);
      if constexpr (Query::kFilters) drop_hidden(filter, shear, pair, verdict);
      if (verdict.possible != 0 && visit_candidates(pair, verdict)) return true;
    }
    return false;
  }

 private:
  TREELET_INLINE bool visit_candidates(const BlockPair& pair, Verdict verdict) {
    if constexpr (Query::kAny) {
      visitor.found = verdict.certain != 0;
      if (visitor.found) return true;
    }
    const float limit = visitor.t_limit();
    const TriangleBlock* const blocks[2] = {pair.first, pair.second};
    for (int i = 0; i < kBlocks; ++i) {
      const unsigned lanes = verdict.possible >> (4 * i) & 0xf;
      if (lanes != 0 && visit_block(*blocks[i], lanes)) return true;
    }
    if (visitor.t_limit() != limit) Base::update_limit();
    return false;
  }

  TREELET_INLINE bool visit_block(const TriangleBlock& block, unsigned lanes) {
    const BlockHits hits = intersect_in_doubles(shear, block);
    for (unsigned mask = hits.met & lanes; mask != 0; mask &= mask - 1) {
      const int i = __builtin_ctz(mask);
      if (visitor.visit(block.face[i], {hits.t[i], hits.u[i], hits.v[i]})) return true;
    }
    for (unsigned mask = hits.unsure & lanes; mask != 0; mask &= mask - 1) {
      const int i = __builtin_ctz(mask);
      TriangleHit hit;
      if (intersect_exactly(shear, block, i, hit) && visitor.visit(block.face[i], hit)) return true;
    }
    return false;
  }
};

}  // namespace
}  // namespace treelet::TREELET_ISA
