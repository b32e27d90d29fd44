#pragma once

#include <chrono>
#include <cmath>

// Correctly rounded arithmetic, CUDA's global min and max, the clock. Exact as on the device where
// the host compiles without contraction.

inline float __fadd_rn(float a, float b) { return a + b; }
inline float __fsub_rn(float a, float b) { return a - b; }
inline float __fmul_rn(float a, float b) { return a * b; }
inline float __fdiv_rn(float a, float b) { return a / b; }
inline float __fmaf_rn(float a, float b, float c) { return std::fma(a, b, c); }
inline float __fsqrt_rn(float a) { return std::sqrt(a); }
inline float __frcp_rn(float a) { return 1.0f / a; }
inline double __dadd_rn(double a, double b) { return a + b; }
inline double __dsub_rn(double a, double b) { return a - b; }
inline double __dmul_rn(double a, double b) { return a * b; }
inline double __ddiv_rn(double a, double b) { return a / b; }
inline double __fma_rn(double a, double b, double c) { return std::fma(a, b, c); }
inline double __dsqrt_rn(double a) { return std::sqrt(a); }

inline int __float2int_rd(float a) { return int(std::floor(a)); }
inline int __float2int_ru(float a) { return int(std::ceil(a)); }
inline int __float2int_rn(float a) { return int(std::nearbyint(a)); }
inline int __float2int_rz(float a) { return int(a); }
inline unsigned __float2uint_rd(float a) { return unsigned(std::floor(a)); }
inline unsigned __float2uint_rz(float a) { return unsigned(a); }

inline float __saturatef(float a) { return a > 0.0f ? (a < 1.0f ? a : 1.0f) : 0.0f; }
/// Here correctly rounded twice; the device is within 2 ulp.
inline float rsqrtf(float a) { return 1.0f / std::sqrt(a); }

#define TREELET_EMULATOR_MIN_MAX(Result, A, B)                                 \
  inline Result min(A a, B b) {                                                \
    const auto first = static_cast<Result>(a), other = static_cast<Result>(b); \
    return first < other ? first : other;                                      \
  }                                                                            \
  inline Result max(A a, B b) {                                                \
    const auto first = static_cast<Result>(a), other = static_cast<Result>(b); \
    return first > other ? first : other;                                      \
  }

TREELET_EMULATOR_MIN_MAX(int, int, int)
TREELET_EMULATOR_MIN_MAX(unsigned, unsigned, unsigned)
TREELET_EMULATOR_MIN_MAX(unsigned, int, unsigned)
TREELET_EMULATOR_MIN_MAX(unsigned, unsigned, int)
TREELET_EMULATOR_MIN_MAX(long, long, long)
TREELET_EMULATOR_MIN_MAX(unsigned long, unsigned long, unsigned long)
TREELET_EMULATOR_MIN_MAX(unsigned long, long, unsigned long)
TREELET_EMULATOR_MIN_MAX(unsigned long, unsigned long, long)
TREELET_EMULATOR_MIN_MAX(long long, long long, long long)
TREELET_EMULATOR_MIN_MAX(unsigned long long, unsigned long long, unsigned long long)
TREELET_EMULATOR_MIN_MAX(unsigned long long, long long, unsigned long long)
TREELET_EMULATOR_MIN_MAX(unsigned long long, unsigned long long, long long)

#undef TREELET_EMULATOR_MIN_MAX

// Floats: a NaN loses against a number.
inline float min(float a, float b) { return std::fmin(a, b); }
inline float max(float a, float b) { return std::fmax(a, b); }
inline double min(double a, double b) { return std::fmin(a, b); }
inline double max(double a, double b) { return std::fmax(a, b); }
inline double min(float a, double b) { return std::fmin(double(a), b); }
inline double max(float a, double b) { return std::fmax(double(a), b); }
inline double min(double a, float b) { return std::fmin(a, double(b)); }
inline double max(double a, float b) { return std::fmax(a, double(b)); }

inline long long clock64() { return std::chrono::steady_clock::now().time_since_epoch().count(); }
