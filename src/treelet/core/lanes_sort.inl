// Sorting eight integers in a register. Part of core/lanes.inl, for AVX2 and AVX-512.

namespace treelet::TREELET_ISA {
namespace {

/// Lane i gets x[order[i]], of whose bits the last three count.
TREELET_INLINE IntLanes<8> permute(IntLanes<8> x, IntLanes<8> order) {
  return (IntLanes<8>)_mm256_permutevar8x32_epi32((__m256i)x, (__m256i)order);
}

/// The larger of x and other, but the smaller in the lanes `upper`.
template <int upper>
TREELET_INLINE __m256i exchange(__m256i x, __m256i other) {
  return _mm256_blend_epi32(_mm256_max_epi32(x, other), _mm256_min_epi32(x, other), upper);
}

/// A bitonic network: a step exchanges lanes whose numbers differ in the bits given.
TREELET_INLINE IntLanes<8> sort_descending(IntLanes<8> lanes) {
  const __m256i reverse = _mm256_setr_epi32(7, 6, 5, 4, 3, 2, 1, 0);
  __m256i x = (__m256i)lanes;
  x = exchange<0xaa>(x, _mm256_shuffle_epi32(x, 0xb1));                  // 1
  x = exchange<0xcc>(x, _mm256_shuffle_epi32(x, 0x1b));                  // 1 and 2
  x = exchange<0xaa>(x, _mm256_shuffle_epi32(x, 0xb1));                  // 1
  x = exchange<0xf0>(x, _mm256_permutevar8x32_epi32(x, reverse));        // 1, 2 and 4
  x = exchange<0xcc>(x, _mm256_shuffle_epi32(x, 0x4e));                  // 2
  return (IntLanes<8>)exchange<0xaa>(x, _mm256_shuffle_epi32(x, 0xb1));  // 1
}

/// Lanes that were chosen, and -1 for the others.
struct Packed {
  IntLanes<8> lanes;
  unsigned count;  ///< of those that were chosen
};

#if defined(__AVX512VL__)

/// Chooses lanes of x where a <= b and c is not zero, and brings them to the front.
TREELET_INLINE Packed pack_at_most(IntLanes<8> x, Lanes<8> a, Lanes<8> b, IntLanes<8> c) {
  const __mmask8 used = _mm256_test_epi32_mask((__m256i)c, (__m256i)c);
  const __mmask8 chosen = _mm256_mask_cmp_ps_mask(used, (__m256)a, (__m256)b, _CMP_LE_OQ);
  const __m256i packed = _mm256_mask_compress_epi32(_mm256_set1_epi32(-1), chosen, (__m256i)x);
  return {(IntLanes<8>)packed, unsigned(__builtin_popcount(chosen))};
}

TREELET_INLINE IntLanes<4> first_four(IntLanes<8> x) {
  return (IntLanes<4>)_mm256_castsi256_si128((__m256i)x);
}
TREELET_INLINE IntLanes<4> permute(IntLanes<8> x, IntLanes<4> order) {
  return first_four(permute(x, (IntLanes<8>)_mm256_castsi128_si256((__m128i)order)));
}

TREELET_INLINE __m128i exchange(__m128i x, __m128i other, __mmask8 lower) {
  return _mm_mask_max_epi32(_mm_min_epi32(x, other), lower, x, other);
}
TREELET_INLINE IntLanes<4> sort_descending(IntLanes<4> lanes) {
  __m128i x = (__m128i)lanes;
  x = exchange(x, _mm_shuffle_epi32(x, 0xb1), 0x5);
  x = exchange(x, _mm_shuffle_epi32(x, 0x1b), 0x3);
  return (IntLanes<4>)exchange(x, _mm_shuffle_epi32(x, 0xb1), 0x5);
}

#else

/// Chooses lanes of x, none negative, where a <= b and c is not zero; they stay where they are.
TREELET_INLINE Packed pack_at_most(IntLanes<8> x, Lanes<8> a, Lanes<8> b, IntLanes<8> c) {
  const IntLanes<8> lanes = (a <= b) & (c != 0) ? x : IntLanes<8>{} - 1;
  const auto others = unsigned(_mm256_movemask_ps((__m256)lanes));
  return {lanes, 8 - unsigned(__builtin_popcount(others))};
}

#endif

}  // namespace
}  // namespace treelet::TREELET_ISA
