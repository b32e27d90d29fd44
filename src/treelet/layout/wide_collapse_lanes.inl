// The chooser with eight lanes in a register, once an instruction set. As the kernels of
// core/lanes.inl it calls no inline function of another header.

#include <treelet/layout/wide_collapse_lanes.h>

#if defined(__AVX2__)
#include <immintrin.h>
#endif

namespace treelet::TREELET_ISA {

#if defined(__AVX2__)
namespace {

using Floats = float __attribute__((vector_size(32)));
using Ints = std::int32_t __attribute__((vector_size(32)));

/// The least costs so far of 1 to 8 children and the shares of the left side that give them, in
/// their places in WideDecision::left_shares.
struct Best {
  Floats cost;
  Ints share;

  /// To c children, the left side gives s and the right side the other c - s: the costs of the
  /// right side, moved up by s lanes; those that come in from its last lane are infinite.
  void consider(float left_cost, Floats moved_up, Ints candidate_share) {
    const Floats candidate = left_cost + moved_up;
    const Ints is_less = candidate < cost;
    cost = is_less ? candidate : cost;
    share = is_less ? candidate_share : share;
  }
};

Best distribute(const WideCosts& left, Floats r) {
  // The factor that puts a share for c children into its place, 3 (c - 2) bits up; none for one.
  constexpr Ints kPlace = {0, 1, 1 << 3, 1 << 6, 1 << 9, 1 << 12, 1 << 15, 1 << 18};
  const float* const l = left.at_most;
  Best best{l[0] + __builtin_shufflevector(r, r, 7, 0, 1, 2, 3, 4, 5, 6), kPlace};
  best.consider(l[1], __builtin_shufflevector(r, r, 7, 7, 0, 1, 2, 3, 4, 5), kPlace * 2);
  best.consider(l[2], __builtin_shufflevector(r, r, 7, 7, 7, 0, 1, 2, 3, 4), kPlace * 3);
  best.consider(l[3], __builtin_shufflevector(r, r, 7, 7, 7, 7, 0, 1, 2, 3), kPlace * 4);
  best.consider(l[4], __builtin_shufflevector(r, r, 7, 7, 7, 7, 7, 0, 1, 2), kPlace * 5);
  best.consider(l[5], __builtin_shufflevector(r, r, 7, 7, 7, 7, 7, 7, 0, 1), kPlace * 6);
  best.consider(l[6], __builtin_shufflevector(r, r, 7, 7, 7, 7, 7, 7, 7, 0), kPlace * 7);
  return best;
}

std::uint32_t combine_bits(Ints a) {
  const __m256i lanes = reinterpret_cast<__m256i>(a);
  __m128i bits = _mm_or_si128(_mm256_castsi256_si128(lanes), _mm256_extracti128_si256(lanes, 1));
  bits = _mm_or_si128(bits, _mm_shuffle_epi32(bits, 0x4e));
  bits = _mm_or_si128(bits, _mm_shuffle_epi32(bits, 0xb1));
  return std::uint32_t(_mm_cvtsi128_si32(bits));
}

/// In halves: they may just have been stored so, and would have to reach memory before one load.
Floats load_halves(const float* costs) {
  return _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_load_ps(costs)), _mm_load_ps(costs + 4),
                              1);
}

WideDecision choose(float as_leaf, float own_cost, const WideCosts& left, const WideCosts& right,
                    WideCosts& costs) {
  const Best spread = distribute(left, load_halves(right.at_most));
  const float as_node = own_cost + spread.cost[7];
  const bool is_leaf = as_leaf <= as_node;
  const float as_one = is_leaf ? as_leaf : as_node;
  const Floats one = _mm256_set1_ps(as_one);
  const Ints whole = one < spread.cost;
  const Floats kept = whole ? one : spread.cost;
  const Floats infinity = _mm256_set1_ps(__builtin_inff());
  _mm256_store_ps(costs.at_most, _mm256_blend_ps(kept, infinity, 1 << 7));

  const unsigned stays_whole = unsigned(_mm256_movemask_ps(reinterpret_cast<__m256>(whole)));
  WideDecision decision{};
  decision.left_shares = combine_bits(spread.share) & 0x1fffff;
  decision.stays_whole = (stays_whole << 1 | 1u << 1) & 0xff;
  decision.is_leaf = is_leaf;
  return decision;
}

}  // namespace

const WideChooser kWideChooser = choose;
#else
const WideChooser kWideChooser = nullptr;
#endif

}  // namespace treelet::TREELET_ISA
