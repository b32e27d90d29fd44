// Floats side by side, for kernels that are compiled once an instruction set. Included without a
// guard by files that define TREELET_ISA, the namespace of their copy. A kernel must call no inline
// function of another header unless that is TREELET_INLINE: the linker merges others by name, and
// would be free to keep the copy that only newer processors run.

#include <cstdint>

#include <treelet/core/platform.h>

#if !defined(TREELET_ISA)
#error "define TREELET_ISA as baseline, avx2 or avx512 before including core/lanes.inl"
#endif

#if !defined(__GNUC__)
#error "treelet's kernels need the vector extensions of GCC or Clang (clang-cl on Windows)"
#endif
#if !defined(__clang__) && !defined(__AVX__)
#pragma GCC diagnostic ignored "-Wpsabi"  // lanes wider than registers are passed inline only
#endif
#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace treelet::TREELET_ISA {
namespace {

/// Floats in a register.
#if defined(__AVX512F__)
constexpr int kNativeLanes = 16;
#elif defined(__AVX__)
constexpr int kNativeLanes = 8;
#else
constexpr int kNativeLanes = 4;
#endif

// One by one: GCC ignores a vector size that depends on a template's parameter.
template <int N>
struct LanesType;
template <>
struct LanesType<4> {
  using Type = float __attribute__((vector_size(16)));
};
template <>
struct LanesType<8> {
  using Type = float __attribute__((vector_size(32)));
};
template <>
struct LanesType<16> {
  using Type = float __attribute__((vector_size(64)));
};
template <int N>
using Lanes = typename LanesType<N>::Type;
using Doubles = double __attribute__((vector_size(32)));  // four
using EightDoubles = double __attribute__((vector_size(64)));

/// What comparing lanes gives: integers of their size, all bits set where it holds.
template <class L>
using MaskOf = decltype(L{} < L{});
template <int N>
using IntLanes = MaskOf<Lanes<N>>;

// Each is one instruction; of equal values the first operand wins, as in core/vec.h, and so does
// the first where the second is NaN.
template <class L>
TREELET_INLINE L min(L a, L b) {
  return b < a ? b : a;
}
template <class L>
TREELET_INLINE L max(L a, L b) {
  return a < b ? b : a;
}
template <class L>
TREELET_INLINE L select_if_at_most(L x, L limit, L yes, L no) {
  return x <= limit ? yes : no;
}
template <class L>
TREELET_INLINE L broadcast(float x) {
  return x - L{};  // nothing but x to a compiler, which must add a zero for -0
}

#if defined(__AVX512F__)
#define TREELET_COMPARE_512(a, b, op) unsigned(_mm512_cmp_ps_mask((__m512)a, (__m512)b, op))
#endif
#if defined(__AVX512VL__)
#define TREELET_COMPARE_256(a, b, op) unsigned(_mm256_cmp_ps_mask((__m256)a, (__m256)b, op))
#define TREELET_COMPARE_128(a, b, op) unsigned(_mm_cmp_ps_mask((__m128)a, (__m128)b, op))
#elif defined(__AVX__)
#define TREELET_COMPARE_256(a, b, op) \
  unsigned(_mm256_movemask_ps(_mm256_cmp_ps((__m256)a, (__m256)b, op)))
#define TREELET_COMPARE_128(a, b, op) \
  unsigned(_mm_movemask_ps(_mm_cmp_ps((__m128)a, (__m128)b, op)))
#endif

/// Bit i: a[i] <= b[i], and neither is NaN.
template <class L>
TREELET_INLINE unsigned at_most_mask(L a, L b) {
#if defined(__AVX512F__)
  if constexpr (sizeof(L) == 64) return TREELET_COMPARE_512(a, b, _CMP_LE_OQ);
#endif
#if defined(__AVX__)
  if constexpr (sizeof(L) == 32) return TREELET_COMPARE_256(a, b, _CMP_LE_OQ);
  if constexpr (sizeof(L) == 16) return TREELET_COMPARE_128(a, b, _CMP_LE_OQ);
#elif defined(__SSE2__)
  if constexpr (sizeof(L) == 16) {
    return unsigned(_mm_movemask_ps(_mm_cmple_ps((__m128)a, (__m128)b)));
  }
#endif
  unsigned mask = 0;
  for (unsigned i = 0; i < sizeof(L) / sizeof(float); ++i) mask |= unsigned(a[i] <= b[i]) << i;
  return mask;
}

/// Bit i: a[i] < b[i], and neither is NaN.
template <class L>
TREELET_INLINE unsigned less_mask(L a, L b) {
#if defined(__AVX512F__)
  if constexpr (sizeof(L) == 64) return TREELET_COMPARE_512(a, b, _CMP_LT_OQ);
#endif
#if defined(__AVX__)
  if constexpr (sizeof(L) == 32) return TREELET_COMPARE_256(a, b, _CMP_LT_OQ);
  if constexpr (sizeof(L) == 16) return TREELET_COMPARE_128(a, b, _CMP_LT_OQ);
#elif defined(__SSE2__)
  if constexpr (sizeof(L) == 16) {
    return unsigned(_mm_movemask_ps(_mm_cmplt_ps((__m128)a, (__m128)b)));
  }
#endif
  unsigned mask = 0;
  for (unsigned i = 0; i < sizeof(L) / sizeof(float); ++i) mask |= unsigned(a[i] < b[i]) << i;
  return mask;
}

template <class L>
TREELET_INLINE L magnitude(L x) {
  return (L)((MaskOf<L>)x & ~(MaskOf<L>)-L{});  // -0: the sign's bit
}
/// x or -x: where `by` has the sign's bit, the sign changes.
template <class L>
TREELET_INLINE L flip_sign(L x, L by) {
  return (L)((MaskOf<L>)x ^ ((MaskOf<L>)by & (MaskOf<L>)-L{}));
}

/// Bit i: x[i] has other bits.
template <class L>
TREELET_INLINE unsigned differ_mask(L x, int bits) {
  const L zero{}, one = broadcast<L>(1.0f);
  return less_mask(zero, (MaskOf<L>)x != bits ? one : zero);
}

/// Bit i: the mask of doubles holds there.
template <class M>
TREELET_INLINE unsigned sign_mask(M mask) {
#if defined(__AVX512DQ__)
  if constexpr (sizeof(M) == 64) return unsigned(_mm512_movepi64_mask((__m512i)mask));
#endif
#if defined(__AVX__)
  if constexpr (sizeof(M) == 32) return unsigned(_mm256_movemask_pd((__m256d)mask));
#endif
  unsigned bits = 0;
  for (unsigned i = 0; i < sizeof(M) / sizeof(double); ++i) bits |= unsigned(mask[i] < 0) << i;
  return bits;
}

TREELET_INLINE const float* offset_by(const float* values, std::uint32_t bytes) {
  return reinterpret_cast<const float*>(reinterpret_cast<const char*>(values) + bytes);
}

/// From and to memory aligned to the lanes.
template <class L>
TREELET_INLINE L load(const float* values) {
  return *reinterpret_cast<const L*>(values);
}
template <class L>
TREELET_INLINE void store(float* values, L lanes) {
  *reinterpret_cast<L*>(values) = lanes;
}

template <class L>
TREELET_INLINE L load_unaligned(const void* values) {
  L lanes;
  __builtin_memcpy(&lanes, values, sizeof(L));
  return lanes;
}
template <class L>
TREELET_INLINE void store_unaligned(void* values, L lanes) {
  __builtin_memcpy(values, &lanes, sizeof(L));
}

/// Half the lanes from each of two places, or all from the first for four lanes.
template <class L>
TREELET_INLINE L load_halves(const float* low, [[maybe_unused]] const float* high) {
#if defined(__AVX__)
  if constexpr (sizeof(L) == 32) {
    return (L)_mm256_insertf128_ps(_mm256_castps128_ps256(_mm_load_ps(low)), _mm_load_ps(high), 1);
  }
#endif
  return load<L>(low);
}

}  // namespace
}  // namespace treelet::TREELET_ISA

#if defined(__AVX2__)
#include <treelet/core/lanes_sort.inl>
#endif
