#include <treelet/primitive/reference_steps.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <string>

#include "support/random.h"

namespace treelet {
namespace {

constexpr float kLargest = std::numeric_limits<float>::max();

/// Any finite float: most are far from 1, and each eighth is denormal or zero.
float any_float(test::Random& random) {
  auto bits = std::uint32_t(random.bits());
  if (random.below(8) == 0) bits &= 0x807fffff;
  const float x = std::bit_cast<float>(bits);
  return std::isfinite(x) ? x : 0.0f;
}

Aabb any_box(test::Random& random) {
  Vec3 p{any_float(random), any_float(random), any_float(random)};
  const Vec3 q{any_float(random), any_float(random), any_float(random)};
  if (random.below(4) == 0) p.x = q.x;
  if (random.below(4) == 0) p.y = q.y;
  if (random.below(4) == 0) p.z = q.z;
  return {min(p, q), max(p, q)};
}

TEST(ExtentExponent, IsFrexpOfTheLongestExtent) {
  constexpr std::uint64_t seed = 252;
  SCOPED_TRACE("seed " + std::to_string(seed));
  test::Random random(seed);
  for (int i = 0; i < 100'000; ++i) {
    const Aabb box = any_box(random);
    int expected = 0;
    std::frexp(std::max({double(box.upper.x) - box.lower.x, double(box.upper.y) - box.lower.y,
                         double(box.upper.z) - box.lower.z}),
               &expected);
    ASSERT_EQ(extent_exponent(box), expected) << "box " << i;
  }
}

TEST(ExtentExponent, OfPointsAndNothingIsZeroAndOfAllBetweenItsEnds) {
  EXPECT_EQ(extent_exponent(Aabb::empty()), 0);
  EXPECT_EQ(extent_exponent({{3, 4, 5}, {3, 4, 5}}), 0);
  EXPECT_EQ(extent_exponent({{0.0f, 0, 0}, {-0.0f, 0, 0}}), 0);
  EXPECT_EQ(extent_exponent({{0, 0, 0}, {0x1p-149f, 0, 0}}), -148);
  EXPECT_EQ(extent_exponent({{0, -kLargest, 0}, {0, kLargest, 0}}), 129);
}

// One rounding, in double: the product is exact there.
TEST(PowerOfTwoScale, RoundsOnceAndKnowsNoMinusZero) {
  constexpr std::uint64_t seed = 253;
  SCOPED_TRACE("seed " + std::to_string(seed));
  test::Random random(seed);
  for (int exponent = -148; exponent <= 129; ++exponent) {
    const PowerOfTwoScale scale(exponent);
    for (int i = 0; i < 1000; ++i) {
      const float x = any_float(random);
      const double exact = std::ldexp(double(x), -exponent);
      const float expected = float(std::clamp(exact, -0x1p125, 0x1p125)) + 0.0f;
      ASSERT_EQ(std::bit_cast<std::uint32_t>(scale(x)), std::bit_cast<std::uint32_t>(expected))
          << x << " scaled by 2^" << -exponent;
    }
    EXPECT_FALSE(std::signbit(scale(-0.0f)));
  }
}

TEST(PowerOfTwoScale, KeepsDoubledCentroidsFinite) {
  const PowerOfTwoScale scale(-148);
  const Aabb box = scale(Aabb{{-kLargest, kLargest, 0}, {-kLargest, kLargest, 0x1p-149f}});
  const Vec3 centroid = doubled_centroid(box);
  EXPECT_TRUE(is_finite(centroid));
  EXPECT_EQ(box.extent(), (Vec3{0, 0, 0.5f}));
}

TEST(MakeReference, ScalesTheTrianglesBox) {
  const Triangle triangle{{0, 8, -2}, {4, 0, -0.0f}, {-4, 2, 1}};
  const Reference reference = make_reference(triangle, 7, PowerOfTwoScale(2));
  EXPECT_EQ(reference.face, 7u);
  EXPECT_EQ(reference.box(), (Aabb{{-1, 0, -0.5f}, {1, 2, 0.25f}}));
}

}  // namespace
}  // namespace treelet
