#pragma once

#include <bit>
#include <cstdint>

#include <treelet/core/platform.h>

// What ldexp, frexp and ilogb do, from the bits of IEEE 754: host and device get the same.

namespace treelet {

/// 2^exponent, for exponents of normal doubles: -1022 to 1023.
TREELET_HD constexpr double power_of_two(int exponent) {
  return std::bit_cast<double>(std::uint64_t(1023 + exponent) << 52);
}

/// 2^exponent as a float, for -149 to 127: denormal below -126.
TREELET_HD constexpr float float_power_of_two(int exponent) {
  const std::uint32_t bits =
      exponent < -126 ? std::uint32_t{1} << (149 + exponent) : std::uint32_t(127 + exponent) << 23;
  return std::bit_cast<float>(bits);
}

/// Coordinates of build space end here. A mesh of extent 1 that reaches so far is flat there, and
/// its doubled centroids must not overflow.
constexpr float kBuildSpaceLimit = 0x1p125f;

/// k such that x is in [2^k, 2^(k + 1)), for a positive normal double; 1024 for infinity.
TREELET_HD constexpr int floor_log2(double x) {
  return int(std::bit_cast<std::uint64_t>(x) >> 52) - 1023;
}

}  // namespace treelet
