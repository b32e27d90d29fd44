// All crossings of a few rays at once, in no order: visits wait in two lists that the rays share.
// Part of enumerate_bvh8_kernel.inl.

namespace treelet::TREELET_ISA {
namespace {

#if defined(__AVX2__) && !defined(__AVX512VL__)

/// By mask: the places of its bits, a byte each.
struct BitPlaces {
  std::uint64_t bytes[256] = {};

  constexpr BitPlaces() {
    for (unsigned mask = 0; mask < 256; ++mask) {
      unsigned count = 0;
      for (unsigned bit = 0; bit < 8; ++bit) {
        if ((mask >> bit & 1) != 0) bytes[mask] |= std::uint64_t(bit) << (8 * count++);
      }
    }
  }
};
constexpr BitPlaces kBitPlaces;

#endif

/// A list on its way.
struct Appender {
  std::uint32_t *rays, *children;
  std::uint32_t size;

  TREELET_INLINE explicit Appender(const VisitList& list)
      : rays(list.rays), children(list.children), size(list.size) {}

  /// Appends the children of a mask. Writes eight entries, whatever the mask.
  TREELET_INLINE void append(std::uint32_t ray, const WideChild* child, unsigned mask) {
    std::uint32_t* const places = children + size;
#if defined(__AVX512VL__)
    const auto all = load_unaligned<IntLanes<8>>(child);
    store_unaligned(places, (IntLanes<8>)_mm256_maskz_compress_epi32(__mmask8(mask), (__m256i)all));
#elif defined(__AVX2__)
    const __m128i bytes = _mm_cvtsi64_si128((long long)(kBitPlaces.bytes[mask]));
    const auto order = (IntLanes<8>)_mm256_cvtepu8_epi32(bytes);
    store_unaligned(places, permute(load_unaligned<IntLanes<8>>(child), order));
#else
    unsigned count = 0;
    for (unsigned left = mask; left != 0; left &= left - 1) {
      places[count++] = child[__builtin_ctz(left)].bits;
    }
#endif
    store_unaligned(rays + size, IntLanes<8>{} + std::int32_t(ray));
    size += unsigned(__builtin_popcount(mask));
  }
};

/// Which of a node's children a ray meets, bit by child.
struct MetChildren {
  unsigned nodes, leaves;
};

TREELET_INLINE MetChildren meet_children(const RaySlabs& ray, const Bvh8Node& node) {
  unsigned met = 0, leaves = 0, used = 0;
  for (int first = 0; first < kWidth; first += kBoxLanes) {
    const BoxSpans span = intersect_boxes(ray, node, first);
    met |= at_most_mask(span.enter, span.leave) << first;
    const auto child = load_unaligned<MaskOf<BoxLanes>>(node.child + first);
    const BoxLanes zero{}, one = broadcast<BoxLanes>(1.0f);
    leaves |= less_mask(zero, child < 0 ? one : zero) << first;
    used |= less_mask(zero, child != 0 ? one : zero) << first;
  }
  return {met & used & ~leaves, met & leaves};
}

constexpr std::uint32_t kTurn = 16;

/// Visits that are made next, or whose memory is fetched meanwhile.
struct Turn {
  std::uint32_t rays[kTurn], children[kTurn];
  std::uint32_t count = 0;

  /// The last of a list.
  TREELET_INLINE void take(VisitList& list) {
    count = list.size < kTurn ? list.size : kTurn;
    list.size -= count;
    __builtin_memcpy(rays, list.rays + list.size, sizeof(rays));
    __builtin_memcpy(children, list.children + list.size, sizeof(children));
  }
};

/// Rays that start together and are done together. Each turn takes the last visits of a list, so
/// that which child is visited next does not hang on what the one before has met.
template <class Record>
class Frontier {
 public:
  TREELET_INLINE Frontier(const Bvh8View& bvh, const Ray* rays, std::size_t count,
                          HitSink<Record>& sink, VisitLists& lists)
      : bvh_(bvh), scene_(bvh.bounds), source_(rays), count_(count), sink_(sink), lists_(lists) {}

  TREELET_INLINE std::size_t run() {
    lists_.nodes.size = lists_.leaves.size = 0;
    make_room();
    while (next_ != count_ && !sink_.has_enough()) {
      start_rays();
      drain();
    }
    return next_;
  }

 private:
  /// For what the nodes of a turn may append.
  TREELET_INLINE void make_room() {
    lists_.nodes.make_room(kWidth * kTurn);
    lists_.leaves.make_room(kWidth * kTurn);
  }

  TREELET_INLINE void start_rays() {
    VisitList& list = lists_.nodes;
    list.make_room(kFrontierRays);
    for (std::uint32_t i = 0; i < kFrontierRays && next_ != count_; ++next_) {
      rays_[i].number = next_;
      if (!rays_[i].begin(source_[next_], scene_)) continue;
      list.rays[list.size] = i++;
      list.children[list.size++] = 0;
    }
  }

  /// Makes the visits that were fetched the turn before, and fetches those of the next.
  TREELET_INLINE void drain() {
    Turn nodes[2], leaves[2];
    for (unsigned next = 0;; next ^= 1) {
      nodes[next].take(lists_.nodes);
      leaves[next].take(lists_.leaves);
      const bool is_last = nodes[next].count + leaves[next].count == 0;
      visit_nodes(nodes[next ^ 1], nodes[next]);
      visit_leaves(leaves[next ^ 1], leaves[next]);
      if (is_last && lists_.nodes.size + lists_.leaves.size == 0) return;
    }
  }

  TREELET_INLINE void visit_nodes(const Turn& turn, const Turn& ahead) {
    make_room();
    Appender nodes(lists_.nodes), leaves(lists_.leaves);
    std::uint32_t k = 0;
    for (; k < turn.count; ++k) {
      if (k < ahead.count) fetch_node(ahead.children[k]);
      const Bvh8Node& node = bvh_.nodes[turn.children[k]];
      const std::uint32_t ray = turn.rays[k];
      const MetChildren met = meet_children(rays_[ray].slabs, node);
      nodes.append(ray, node.child, met.nodes);
      leaves.append(ray, node.child, met.leaves);
    }
    for (; k < ahead.count; ++k) fetch_node(ahead.children[k]);
    lists_.nodes.size = nodes.size;
    lists_.leaves.size = leaves.size;
  }

  TREELET_INLINE void visit_leaves(const Turn& turn, const Turn& ahead) {
    std::uint32_t k = 0;
    for (; k < turn.count; ++k) {
      if (k < ahead.count) fetch_leaf(ahead.children[k]);
      const WideChild leaf{turn.children[k]};
      const EnumeratedRay& ray = rays_[turn.rays[k]];
      push_crossings(ray, source_[ray.number], bvh_.blocks + leaf.first_block(), leaf.block_count(),
                     bvh_.filter, sink_);
    }
    for (; k < ahead.count; ++k) fetch_leaf(ahead.children[k]);
  }

  TREELET_INLINE void fetch_node(std::uint32_t node) const {
    fetch(bvh_.nodes + node, sizeof(Bvh8Node));
  }
  TREELET_INLINE void fetch_leaf(std::uint32_t leaf) const {
    fetch(bvh_.blocks + WideChild{leaf}.first_block(), kBlocks * sizeof(TriangleBlock));
  }
  static TREELET_INLINE void fetch(const void* memory, unsigned bytes) {
    for (unsigned offset = 0; offset < bytes; offset += 64) {
      __builtin_prefetch(static_cast<const char*>(memory) + offset);
    }
  }

  const Bvh8View& bvh_;
  const SceneLanes scene_;
  const Ray* const source_;
  const std::size_t count_;
  HitSink<Record>& sink_;
  VisitLists& lists_;
  std::uint32_t next_ = 0;
  EnumeratedRay rays_[kFrontierRays];
};

}  // namespace
}  // namespace treelet::TREELET_ISA
