// Floats side by side, for kernels that are compiled once an instruction set. Included without a
// guard by files that define TREELET_ISA, the namespace of their copy. A kernel must call no inline
// function of another header unless that is TREELET_INLINE: the linker merges others by name, and
// would be free to keep the copy that only newer processors run.

#include <treelet/core/platform.h>

#if !defined(TREELET_ISA)
#error "define TREELET_ISA as baseline, avx2 or avx512 before including core/lanes.inl"
#endif

#if !defined(__GNUC__)
#error "treelet's kernels need the vector extensions of GCC or Clang (clang-cl on Windows)"
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
  return L{} + x;
}

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

/// From and to memory aligned to the lanes.
template <class L>
TREELET_INLINE L load(const float* values) {
  return *reinterpret_cast<const L*>(values);
}
template <class L>
TREELET_INLINE void store(float* values, L lanes) {
  *reinterpret_cast<L*>(values) = lanes;
}

}  // namespace
}  // namespace treelet::TREELET_ISA
