#include <treelet/core/wide_integer.h>

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "support/big_integer.h"
#include "support/random.h"

namespace treelet {
namespace {

using test::BigInteger;
using test::Random;

/// Any finite double, or one of few bits, of which sums and products cancel often.
double random_double(Random& random, int smallest_exponent, int largest_exponent) {
  const int range = largest_exponent - smallest_exponent;
  const int exponent = smallest_exponent + int(random.below(std::uint64_t(range)));
  const int bits = random.below(2) == 0 ? 53 : 4;
  const double digits = double(random.bits() >> (64 - bits));
  return std::ldexp(random.below(2) == 0 ? digits : -digits, exponent);
}

TEST(WideInteger, ComputesTheSignsOfBigIntegers) {
  constexpr int kSmallest = -1074, kLargest = 970;
  Random random(1);
  for (int i = 0; i < 300; ++i) {
    const int span = i % 2 == 0 ? 20 : kLargest - kSmallest;
    const int first = kSmallest + int(random.below(std::uint64_t(kLargest - kSmallest - span + 1)));
    double x[4];
    for (double& value : x) value = random_double(random, first, first + span);
    const auto wide = [&](int k) { return WideInteger(x[k], first); };
    const auto big = [&](int k) { return BigInteger::from_scaled(x[k], -first); };
    EXPECT_EQ((wide(0) - wide(1)).sign(), (big(0) - big(1)).sign());
    EXPECT_EQ((wide(0) * wide(1) - wide(2) * wide(3)).sign(),
              (big(0) * big(1) - big(2) * big(3)).sign());
    EXPECT_EQ((wide(0) * wide(1) * wide(2) - wide(1) * wide(0) * wide(2)).sign(), 0);
  }
}

TEST(WideInteger, QuotientsAreThoseOfDoubles) {
  Random random(2);
  for (int i = 0; i < 2000; ++i) {
    const double a = random_double(random, -40, 40), b = random_double(random, -40, 40);
    if (b == 0.0) continue;
    const int exponent = -100;
    const double found = quotient(WideInteger(a, exponent), WideInteger(b, exponent), 0);
    EXPECT_EQ(found, a / b) << a << " / " << b;
    EXPECT_EQ(quotient(WideInteger(a, exponent), WideInteger(b, exponent), 7), a / b * 128);
  }
}

TEST(WideInteger, QuotientsAreNeverZeroUnlessTheyAre) {
  const WideInteger one(1.0, 0), three(3.0, 0);
  constexpr double kTiny = std::numeric_limits<double>::denorm_min();
  EXPECT_EQ(quotient(one, three, -3000), kTiny);
  EXPECT_EQ(quotient(-one, three, -3000), -kTiny);
  EXPECT_EQ(quotient(one, three, 3000), std::numeric_limits<double>::infinity());
  EXPECT_EQ(quotient(WideInteger(), three, 0), 0.0);
  EXPECT_FALSE(std::signbit(quotient(WideInteger(), -three, 0)));
  EXPECT_EQ(quotient(WideInteger(1e300, -1074), WideInteger(5e-324, -1074), 0),
            std::numeric_limits<double>::infinity());
}

TEST(WideInteger, LowestBits) {
  EXPECT_EQ(lowest_bit(1.0), 0);
  EXPECT_EQ(lowest_bit(-6.0), 1);
  EXPECT_EQ(lowest_bit(0.75), -2);
  EXPECT_EQ(lowest_bit(5e-324), -1074);
  EXPECT_EQ(lowest_bit(std::numeric_limits<double>::max()), 971);
  EXPECT_GT(lowest_bit(0.0), 1024);
}

TEST(WideInteger, HoldsAProductOfThreeLargestDifferences) {
  constexpr double kMax = std::numeric_limits<double>::max();
  const WideInteger large(kMax, -1074), tiny(5e-324, -1074);
  const WideInteger difference = large + large - tiny;
  const WideInteger volume = difference * difference * difference;
  EXPECT_EQ(quotient(volume * WideInteger() + volume, volume, 0), 1.0);
  EXPECT_EQ((volume + volume + volume + volume + volume + volume).sign(), 1);
}

}  // namespace
}  // namespace treelet
