// Floats side by side, as many as a register holds, for kernels that are compiled once an
// instruction set. Included without a guard by files that define TREELET_ISA, the namespace of
// their copy. A kernel must force everything inline and call no inline function of another header:
// the linker merges those by name, and would be free to keep the copy that only newer processors
// run.

#if !defined(TREELET_ISA)
#error "define TREELET_ISA as baseline, avx2 or avx512 before including core/lanes.h"
#endif

#if defined(__GNUC__)
#define TREELET_INLINE inline __attribute__((always_inline))
#else
#define TREELET_INLINE inline
#endif

namespace treelet::TREELET_ISA {
namespace {

#if defined(__AVX512F__)
constexpr int kLanes = 16;
#elif defined(__AVX__)
constexpr int kLanes = 8;
#else
constexpr int kLanes = 4;
#endif

#if defined(__GNUC__)

using Lanes = float __attribute__((vector_size(4 * kLanes)));

TREELET_INLINE Lanes broadcast(float x) { return Lanes{} + x; }
// Both compile to one instruction; of equal values the first operand wins, as in core/vec.h.
TREELET_INLINE Lanes min(Lanes a, Lanes b) { return b < a ? b : a; }
TREELET_INLINE Lanes max(Lanes a, Lanes b) { return a < b ? b : a; }
TREELET_INLINE Lanes select_if_at_most(Lanes x, Lanes limit, Lanes yes, Lanes no) {
  return x <= limit ? yes : no;
}

#else

struct alignas(4 * kLanes) Lanes {
  float value[kLanes];
};

template <class Operation>
TREELET_INLINE Lanes lane_by_lane(Operation operation) {
  Lanes result;
  for (int i = 0; i < kLanes; ++i) result.value[i] = operation(i);
  return result;
}
TREELET_INLINE Lanes operator+(const Lanes& a, const Lanes& b) {
  return lane_by_lane([&](int i) { return a.value[i] + b.value[i]; });
}
TREELET_INLINE Lanes operator-(const Lanes& a, const Lanes& b) {
  return lane_by_lane([&](int i) { return a.value[i] - b.value[i]; });
}
TREELET_INLINE Lanes operator*(const Lanes& a, const Lanes& b) {
  return lane_by_lane([&](int i) { return a.value[i] * b.value[i]; });
}
TREELET_INLINE Lanes broadcast(float x) {
  return lane_by_lane([&](int) { return x; });
}
TREELET_INLINE Lanes min(const Lanes& a, const Lanes& b) {
  return lane_by_lane([&](int i) { return b.value[i] < a.value[i] ? b.value[i] : a.value[i]; });
}
TREELET_INLINE Lanes max(const Lanes& a, const Lanes& b) {
  return lane_by_lane([&](int i) { return a.value[i] < b.value[i] ? b.value[i] : a.value[i]; });
}
TREELET_INLINE Lanes select_if_at_most(const Lanes& x, const Lanes& limit, const Lanes& yes,
                                       const Lanes& no) {
  return lane_by_lane(
      [&](int i) { return x.value[i] <= limit.value[i] ? yes.value[i] : no.value[i]; });
}

#endif

/// From memory aligned to a register.
TREELET_INLINE Lanes load(const float* values) { return *reinterpret_cast<const Lanes*>(values); }
TREELET_INLINE void store(float* values, Lanes lanes) { *reinterpret_cast<Lanes*>(values) = lanes; }

}  // namespace
}  // namespace treelet::TREELET_ISA
