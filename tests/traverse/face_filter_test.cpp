#include <treelet/traverse/face_filter.h>

#include <gtest/gtest.h>

#include <treelet/core/exact.h>

#include <algorithm>
#include <cmath>

#include "support/random.h"

namespace treelet {
namespace {

constexpr Triangle kTriangle{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};  // counter-clockwise from above

int exact_side(Vec3 direction, const Triangle& t) {
  const double volume = exact_triple_product(direction, t.p0, t.p1, t.p2);
  return (volume > 0.0) - (volume < 0.0);
}

TEST(SideOf, FrontIsWhereCornersTurnCounterClockwise) {
  EXPECT_EQ(side_of({0, 0, -1}, kTriangle), -1);
  EXPECT_EQ(side_of({0.5f, 3, 1e-30f}, kTriangle), 1);
  EXPECT_EQ(side_of({1, 2, 0}, kTriangle), 0);
}

TEST(SideOf, IsExactForRaysAlongTheTriangle) {
  test::Random random(7);
  int edge_on = 0, beside = 0;
  for (int i = 0; i < 100000; ++i) {
    const float scale = std::ldexp(1.0f, int(random.below(200)) - 100);
    const float far = i % 3 == 0 ? 0.0f : 1000.0f;
    const auto point = [&] { return (random.point(-1, 1) + Vec3{far, -far, far}) * scale; };
    const Triangle t{point(), point(), point()};
    // In the plane but for rounding, or exactly where the difference is exact.
    const Vec3 along = i % 2 == 0 ? t.p1 - t.p0 : (t.p1 - t.p0) * 0.3f + (t.p2 - t.p0) * 0.6f;
    const int side = exact_side(along, t);
    ASSERT_EQ(side_of(along, t), side) << "seed 7, case " << i;
    edge_on += side == 0;
    beside += side != 0;
  }
  EXPECT_GT(edge_on, 1000);
  EXPECT_GT(beside, 1000);
}

TEST(SideOf, IsExactForSlivers) {
  test::Random random(8);
  for (int i = 0; i < 20000; ++i) {
    const Vec3 a = random.point(-1, 1), way = random.point(-1, 1);
    const Triangle t{a, a + way, a + way * random.uniform(0, 2)};
    const Vec3 direction = random.point(-1, 1);
    ASSERT_EQ(side_of(direction, t), exact_side(direction, t)) << "seed 8, case " << i;
  }
}

TEST(FaceFilter, HidesFacesBySideAndByNumber) {
  const bool mask[] = {true, false};
  FaceFilter filter;
  EXPECT_TRUE(filter.is_open());
  filter.mask = mask;
  EXPECT_FALSE(filter.is_open());
  EXPECT_TRUE(filter.has(0));
  EXPECT_FALSE(filter.has(1));
  const Vec3 down{0, 0, -1}, up{0, 0, 1};
  EXPECT_TRUE(filter.shows(down, kTriangle));
  EXPECT_TRUE(filter.shows(up, kTriangle));
  filter.cull = Cull::back;
  EXPECT_TRUE(filter.shows(down, kTriangle));
  EXPECT_FALSE(filter.shows(up, kTriangle));
  filter.cull = Cull::front;
  EXPECT_FALSE(filter.shows(down, kTriangle));
  EXPECT_TRUE(filter.shows(up, kTriangle));
}

}  // namespace
}  // namespace treelet
