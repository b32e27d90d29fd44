#include <treelet/core/vec.h>

#include <gtest/gtest.h>

#include <cmath>

namespace treelet {
namespace {

TEST(Vec3, ArithmeticIsByComponent) {
  const Vec3 a{1, 2, 3}, b{10, 20, 40};
  EXPECT_EQ(a + b, (Vec3{11, 22, 43}));
  EXPECT_EQ(b - a, (Vec3{9, 18, 37}));
  EXPECT_EQ(a * 2.0f, (Vec3{2, 4, 6}));
}

TEST(Vec3, IndexNamesTheAxis) {
  const Vec3 a{1, 2, 3};
  EXPECT_EQ(a[0], 1);
  EXPECT_EQ(a[1], 2);
  EXPECT_EQ(a[2], 3);
}

TEST(Vec3, MinAndMaxAreByComponent) {
  const Vec3 a{1, 20, 3}, b{10, 2, 3};
  EXPECT_EQ(min(a, b), (Vec3{1, 2, 3}));
  EXPECT_EQ(max(a, b), (Vec3{10, 20, 3}));
}

TEST(Vec3, OfAnEqualPairMinAndMaxGiveTheFirst) {
  EXPECT_FALSE(std::signbit(min(0.0f, -0.0f)));
  EXPECT_TRUE(std::signbit(min(-0.0f, 0.0f)));
  EXPECT_FALSE(std::signbit(max(0.0f, -0.0f)));
  EXPECT_TRUE(std::signbit(max(-0.0f, 0.0f)));
}

TEST(Vec3, MaxComponentFindsTheLargestOnEveryAxis) {
  EXPECT_EQ(max_component({3, 1, 2}), 3);
  EXPECT_EQ(max_component({1, 3, 2}), 3);
  EXPECT_EQ(max_component({1, 2, 3}), 3);
  EXPECT_EQ(max_component({-3, -1, -2}), -1);
}

}  // namespace
}  // namespace treelet
