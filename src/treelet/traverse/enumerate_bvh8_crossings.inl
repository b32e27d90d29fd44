// A ray's crossings of the triangles of a leaf. Part of enumerate_bvh8_kernel.inl.

namespace treelet::TREELET_ISA {
namespace {

TREELET_INLINE void push(HitSink<RayHit>& sink, std::uint32_t ray, std::uint32_t face,
                         const TriangleHit& hit) {
  sink.push({ray, std::int32_t(face), hit.t, hit.u, hit.v});
}
TREELET_INLINE void push(HitSink<RayFace>& sink, std::uint32_t ray, std::uint32_t face,
                         const TriangleHit&) {
  sink.push({ray, std::int32_t(face)});
}

/// Hits are kept sorted, each face once. As soon as there are enough, the last is a limit for
/// those to come; one as far as it may still take its place.
TREELET_INLINE void push(FirstHits& found, std::uint32_t, std::uint32_t number,
                         const TriangleHit& hit) {
  const auto face = std::int32_t(number);
  std::uint32_t place = found.count;
  for (; place != 0; --place) {
    const Hit& before = found.hits[place - 1];
    if (before.t < hit.t || (before.t == hit.t && before.face < face)) break;
    if (before.face == face) return;
  }
  if (place == found.most) return;
  found.count += found.count != found.most;
  for (std::uint32_t i = found.count - 1; i > place; --i) found.hits[i] = found.hits[i - 1];
  found.hits[place] = {hit.t, face, hit.u, hit.v};
}

/// Returns which lanes it has pushed: of those, floats tell that they are crossed.
template <class State>
TREELET_INLINE unsigned push_certain(const State& ray, const TriangleBlock& block, unsigned lanes,
                                     HitSink<RayFace>& sink) {
  for (unsigned mask = lanes; mask != 0; mask &= mask - 1) {
    push(sink, ray.number, block.face[__builtin_ctz(mask)], {});
  }
  return lanes;
}
/// Where t may have to be moved to have the right sign, it is left to crosses_within_limits.
template <class State, class Sink>
TREELET_INLINE unsigned push_certain(const State& ray, const TriangleBlock& block, unsigned lanes,
                                     Sink& sink) {
  if (!ray.is_t_positive) return 0;
  const BlockHits hits = intersect_in_doubles(ray.shear, block);
  const unsigned positive = less_mask(Lanes<4>{}, load<Lanes<4>>(hits.t));
  const unsigned pushed = lanes & hits.met & positive;
  for (unsigned mask = pushed; mask != 0; mask &= mask - 1) {
    const int i = __builtin_ctz(mask);
    push(sink, ray.number, block.face[i], {hits.t[i], hits.u[i], hits.v[i]});
  }
  return pushed;
}

/// Certain crossings are strictly inside of the triangle and of the limits.
template <class State, class Sink>
TREELET_INLINE void push_crossings(const State& ray, const Ray& source, const TriangleBlock& block,
                                   unsigned possible, unsigned certain, Sink& sink) {
  certain &= possible;
  if (certain != 0) certain = push_certain(ray, block, certain, sink);
  for (unsigned mask = possible & ~certain; mask != 0; mask &= mask - 1) {
    const int i = __builtin_ctz(mask);
    TriangleHit hit;
    if (crosses_within_limits(source, block, unsigned(i), hit)) {
      push(sink, ray.number, block.face[i], hit);
    }
  }
}

/// All crossings of the triangles of a leaf's blocks.
template <class State, class Sink>
TREELET_INLINE void push_crossings(const State& ray, const Ray& source, const TriangleBlock* blocks,
                                   unsigned count, const FaceFilter& filter, Sink& sink) {
  for (unsigned i = 0; i < count; i += kBlocks) {
    const unsigned second = i + kBlocks <= count ? i + kBlocks - 1 : i;
    const BlockPair pair{blocks + i, blocks + second};
    Verdict verdict = test_triangles(ray.shear, pair, pair.used_lanes());
    if (verdict.possible == 0) continue;
    if (!filter.is_open()) [[unlikely]]
      drop_hidden(filter, ray.shear, pair, verdict);
    const TriangleBlock* const tested[2] = {pair.first, pair.second};
    for (int k = 0; k < kBlocks; ++k) {
      const unsigned possible = verdict.possible >> (4 * k) & 0xf;
      if (possible == 0) continue;
      push_crossings(ray, source, *tested[k], possible, verdict.certain >> (4 * k), sink);
    }
  }
}

}  // namespace
}  // namespace treelet::TREELET_ISA
