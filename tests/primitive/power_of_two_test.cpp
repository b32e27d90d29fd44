#include <treelet/primitive/power_of_two.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "support/random.h"

namespace treelet {
namespace {

TEST(PowerOfTwo, IsLdexpForAllNormalDoubles) {
  for (int exponent = -1022; exponent <= 1023; ++exponent) {
    ASSERT_EQ(power_of_two(exponent), std::ldexp(1.0, exponent)) << exponent;
  }
}

TEST(FloatPowerOfTwo, IsLdexpForAllFloats) {
  for (int exponent = -149; exponent <= 127; ++exponent) {
    ASSERT_EQ(float_power_of_two(exponent), std::ldexp(1.0f, exponent)) << exponent;
  }
}

TEST(FloorLog2, IsIlogbOfNormalDoubles) {
  constexpr std::uint64_t seed = 251;
  SCOPED_TRACE("seed " + std::to_string(seed));
  test::Random random(seed);
  for (int i = 0; i < 100'000; ++i) {
    const double x = std::bit_cast<double>(random.bits() >> 1);
    if (std::isnormal(x)) {
      ASSERT_EQ(floor_log2(x), std::ilogb(x)) << x;
    }
  }
  for (int exponent = -1022; exponent <= 1023; ++exponent) {
    const double x = std::ldexp(1.0, exponent);
    ASSERT_EQ(floor_log2(x), exponent);
    ASSERT_EQ(floor_log2(std::nextafter(x, 1e308)), exponent);
    if (exponent > -1022) {
      ASSERT_EQ(floor_log2(std::nextafter(x, 0.0)), exponent - 1);
    }
  }
  EXPECT_EQ(floor_log2(std::numeric_limits<double>::infinity()), 1024);
}

}  // namespace
}  // namespace treelet
