#include <treelet/core/exact.h>

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "support/big_integer.h"
#include "support/random.h"

namespace treelet {
namespace {

using test::BigInteger;
using test::Random;

// Every float is a multiple of 2^-149, so a product of three is one of 2^-447.
constexpr int kFloatShift = 149;
constexpr int kProductShift = 3 * kFloatShift;

struct Input {
  Vec3 direction, origin, a, b;
};

BigInteger exact(float value) { return BigInteger::from_scaled(value, kFloatShift); }

/// The triple product times 2^447.
BigInteger oracle(const Input& input) {
  std::array<BigInteger, 3> p, q;
  for (int axis = 0; axis < 3; ++axis) {
    p[axis] = exact(input.a[axis]) - exact(input.origin[axis]);
    q[axis] = exact(input.b[axis]) - exact(input.origin[axis]);
  }
  return exact(input.direction.x) * (p[1] * q[2] - p[2] * q[1]) +
         exact(input.direction.y) * (p[2] * q[0] - p[0] * q[2]) +
         exact(input.direction.z) * (p[0] * q[1] - p[1] * q[0]);
}

int sign(double value) { return (value > 0.0) - (value < 0.0); }

/// Checks the sign, and the value to its last bit; returns the sign.
int expect_exact(const Input& input) {
  const double result = exact_triple_product(input.direction, input.origin, input.a, input.b);
  const double swapped = exact_triple_product(input.direction, input.origin, input.b, input.a);
  const BigInteger expected = oracle(input);
  EXPECT_EQ(sign(result), expected.sign());
  EXPECT_EQ(swapped, -result) << "a and b swapped";
  const BigInteger error = BigInteger::from_scaled(result, kProductShift) - expected;
  const BigInteger two_to_52 = BigInteger::from_scaled(1.0, 52);
  EXPECT_LE((error.magnitude() * two_to_52 - expected.magnitude()).sign(), 0)
      << result << " is off by more than one unit of its last place";
  return expected.sign();
}

float next_up(float value, int steps) {
  const float towards =
      steps < 0 ? -std::numeric_limits<float>::infinity() : std::numeric_limits<float>::infinity();
  for (int i = 0; i < std::abs(steps); ++i) value = std::nextafter(value, towards);
  return value;
}

TEST(ExactTripleProduct, OfSmallIntegers) {
  EXPECT_EQ(exact_triple_product({0, 0, 1}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}), 1.0);
  EXPECT_EQ(exact_triple_product({0, 0, 1}, {0, 0, 0}, {0, 1, 0}, {1, 0, 0}), -1.0);
  EXPECT_EQ(exact_triple_product({1, 2, 4}, {1, 1, 1}, {2, 3, 4}, {5, 1, 2}), -8.0);
  EXPECT_EQ(exact_triple_product({1, 0, 0}, {0, 0, 0}, {1, 2, 3}, {2, 4, 6}), 0.0);
}

TEST(ExactTripleProduct, AgreesWithWideIntegers) {
  constexpr std::uint64_t seed = 11;
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  const auto coordinate = [&] { return float(std::int64_t(random.below(1 << 17)) - (1 << 16)); };
  const auto point = [&] { return Vec3{coordinate(), coordinate(), coordinate()}; };
  for (int i = 0; i < 2000; ++i) {
    const Vec3 d = point(), o = point(), a = point(), b = point();
    const Vec3 p = a - o, q = b - o;  // exact: 18 bits
    const auto minor = [](float x, float y, float z, float w) {
      return std::int64_t(x) * std::int64_t(y) - std::int64_t(z) * std::int64_t(w);
    };
    const std::int64_t expected = std::int64_t(d.x) * minor(p.y, q.z, p.z, q.y) +
                                  std::int64_t(d.y) * minor(p.z, q.x, p.x, q.z) +
                                  std::int64_t(d.z) * minor(p.x, q.y, p.y, q.x);
    ASSERT_EQ(exact_triple_product(d, o, a, b), double(expected)) << "round " << i;
  }
}

TEST(ExactTripleProduct, OfRandomFloatsOfAllExponents) {
  constexpr std::uint64_t seed = 12;
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  const auto coordinate = [&](int exponent_range) {
    const int exponent = int(random.below(2 * exponent_range + 1)) - exponent_range;
    return std::ldexp(random.uniform(-1.0f, 1.0f), exponent);
  };
  for (const int range : {0, 3, 30, 126}) {
    const auto point = [&] {
      return Vec3{coordinate(range), coordinate(range), coordinate(range)};
    };
    for (int i = 0; i < 1000; ++i) {
      expect_exact({point(), point(), point(), point()});
      ASSERT_FALSE(HasFailure()) << "range " << range << ", round " << i;
    }
  }
}

// a, b and origin + direction lie on a plane through the origin but for a few units in the last
// place: a double has no idea of the sign.
TEST(ExactTripleProduct, OfNearlyCoplanarPoints) {
  constexpr std::uint64_t seed = 13;
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  const auto perturb = [&](Vec3 p) {
    const auto steps = [&] { return int(random.below(3)) - 1; };
    return Vec3{next_up(p.x, steps()), next_up(p.y, steps()), next_up(p.z, steps())};
  };
  std::array<int, 3> count_by_sign{};
  for (int i = 0; i < 3000; ++i) {
    const Vec3 o = random.point(-1.0f, 1.0f);
    const Vec3 d = random.point(-1.0f, 1.0f), e = random.point(-1.0f, 1.0f);
    const Vec3 a = perturb(o + d * 0.25f + e * 0.5f), b = perturb(o + d * 2.0f - e * 0.125f);
    ++count_by_sign[1 + expect_exact({d, o, a, b})];
    ASSERT_FALSE(HasFailure()) << "round " << i;
  }
  EXPECT_GT(count_by_sign[0], 100);
  EXPECT_GT(count_by_sign[2], 100);
}

// Coplanar integers times a power of two, down to denormals.
TEST(ExactTripleProduct, OfCoplanarPointsMovedByOneUnit) {
  for (const float size : {1.0f, 0x1p100f, 0x1p-100f, 0x1p-130f}) {
    const Vec3 d{size, 2 * size, 3 * size}, o{0, 0, 0};
    const Vec3 a{size, size, size}, b{3 * size, 4 * size, 5 * size};  // b = d + 2 a
    EXPECT_EQ(expect_exact({d, o, a, b}), 0);
    for (int axis = 0; axis < 3; ++axis) {
      std::array<float, 3> moved{b.x, b.y, b.z};
      moved[axis] = next_up(moved[axis], 1);
      const int up = expect_exact({d, o, a, {moved[0], moved[1], moved[2]}});
      moved[axis] = next_up(moved[axis], -2);
      const int down = expect_exact({d, o, a, {moved[0], moved[1], moved[2]}});
      EXPECT_EQ(up, axis == 1 ? 1 : -1) << "size " << size;
      EXPECT_EQ(down, -up) << "size " << size;
    }
  }
}

// a - origin is a multiple of the direction, and too long for a float: products of 48 bits and
// more must cancel to the last.
TEST(ExactTripleProduct, OfPointsOnTheLineIsZero) {
  constexpr std::uint64_t seed = 15;
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 d = random.point(-1.0f, 1.0f);
    const Vec3 a = d * std::ldexp(1.0f, int(random.below(50)));
    const Vec3 b = random.point(-1.0f, 1.0f) * std::ldexp(1.0f, int(random.below(50)) - 10);
    ASSERT_EQ(expect_exact({d, d * -1.0f, a, b}), 0) << "round " << i;
    ASSERT_FALSE(HasFailure()) << "round " << i;
  }
}

TEST(ExactTripleProduct, OfExtremeFloats) {
  constexpr float largest = std::numeric_limits<float>::max();
  constexpr float smallest = std::numeric_limits<float>::denorm_min();
  const std::array<float, 8> values{0.0f, 1.0f, -1.0f, 1e30f, 1e-30f, largest, -largest, smallest};
  constexpr std::uint64_t seed = 14;
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  const auto value = [&] { return values[random.below(values.size())]; };
  const auto point = [&] { return Vec3{value(), value(), value()}; };
  for (int i = 0; i < 3000; ++i) {
    expect_exact({point(), point(), point(), point()});
    ASSERT_FALSE(HasFailure()) << "round " << i;
  }
  EXPECT_EQ(expect_exact({{0, 0, smallest}, {0, 0, 0}, {smallest, 0, 0}, {0, smallest, 0}}), 1);
}

}  // namespace
}  // namespace treelet
