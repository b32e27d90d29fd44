#pragma once

#include <bit>
#include <cstdint>

#include <treelet/core/platform.h>

namespace treelet {

/// Zeros above the highest one; 64 for 0. Device code must not call std::countl_zero of 64 bits nor
/// std::countr_zero: nvcc 13 takes the compiler's builtin in them for a constant, without a word.
TREELET_HD constexpr int count_leading_zeros(std::uint64_t x) {
#if defined(__CUDA_ARCH__)
  return __clzll(static_cast<long long>(x));
#else
  return std::countl_zero(x);
#endif
}

}  // namespace treelet
