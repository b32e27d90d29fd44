#include <treelet/core/aabb.h>

#include <gtest/gtest.h>

namespace treelet {
namespace {

constexpr Aabb kBox{{0, 1, 2}, {3, 5, 8}};

TEST(Aabb, EmptyIsTheIdentityOfMerge) {
  EXPECT_TRUE(Aabb::empty().is_empty());
  EXPECT_EQ(merge(Aabb::empty(), kBox), kBox);
  EXPECT_EQ(merge(kBox, Aabb::empty()), kBox);
  EXPECT_TRUE(merge(Aabb::empty(), Aabb::empty()).is_empty());
}

TEST(Aabb, OfAPointIsNotEmpty) {
  const Aabb point = merge(Aabb::empty(), Vec3{1, 2, 3});
  EXPECT_EQ(point, (Aabb{{1, 2, 3}, {1, 2, 3}}));
  EXPECT_FALSE(point.is_empty());
  EXPECT_EQ(half_area(point), 0.0f);
}

TEST(Aabb, MergeTakesTheOuterSides) {
  EXPECT_EQ(merge(kBox, Aabb{{-1, 2, 3}, {2, 9, 4}}), (Aabb{{-1, 1, 2}, {3, 9, 8}}));
  EXPECT_EQ(merge(kBox, Vec3{4, 0, 3}), (Aabb{{0, 0, 2}, {4, 5, 8}}));
  EXPECT_EQ(merge(kBox, Vec3{1, 2, 3}), kBox);
}

TEST(Aabb, ContainsItselfAndTheEmptyBox) {
  EXPECT_TRUE(kBox.contains(kBox));
  EXPECT_TRUE(kBox.contains(Aabb::empty()));
  EXPECT_TRUE(Aabb::empty().contains(Aabb::empty()));
  EXPECT_FALSE(Aabb::empty().contains(kBox));
}

TEST(Aabb, DoesNotContainWhatSticksOutOfAnySide) {
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3 step{axis == 0 ? 0.5f : 0, axis == 1 ? 0.5f : 0, axis == 2 ? 0.5f : 0};
    EXPECT_FALSE(kBox.contains({kBox.lower - step, kBox.upper})) << "axis " << axis;
    EXPECT_FALSE(kBox.contains({kBox.lower, kBox.upper + step})) << "axis " << axis;
    EXPECT_TRUE(kBox.contains({kBox.lower + step, kBox.upper - step})) << "axis " << axis;
  }
}

TEST(Aabb, HalfAreaIsThatOfThreeSides) {
  EXPECT_EQ(kBox.extent(), (Vec3{3, 4, 6}));
  EXPECT_EQ(half_area(kBox), 3.0f * 4 + 4 * 6 + 6 * 3);
  EXPECT_EQ(half_area_double(kBox), 3.0 * 4 + 4 * 6 + 6 * 3);
  EXPECT_EQ(half_area_double(Aabb::empty()), 0.0);
}

TEST(Aabb, HalfAreaInDoubleNeitherOverflowsNorVanishes) {
  EXPECT_NEAR(half_area_double({{-1e30f, -1e30f, -1e30f}, {1e30f, 1e30f, 1e30f}}) / 12e60, 1.0,
              1e-6);
  EXPECT_NEAR(half_area_double({{0, 0, 0}, {1e-30f, 1e-30f, 1e-30f}}) / 3e-60, 1.0, 1e-6);
}

}  // namespace
}  // namespace treelet
