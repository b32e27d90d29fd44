#include <treelet/traverse/crossing.h>

#include <gtest/gtest.h>

#include <treelet/traverse/crossing_steps.h>

#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "support/exact_crossing.h"
#include "support/random.h"
#include "support/ray_cases.h"

namespace treelet {
namespace {

Ray scaled(const Ray& ray, float factor) {
  Ray result = ray;
  result.origin = ray.origin * factor;
  return result;
}
Triangle scaled(const Triangle& t, float factor) {
  return {t.p0 * factor, t.p1 * factor, t.p2 * factor};
}

/// A case whose origin is moved to where the ray meets the triangle, or rounds to that: t is about
/// zero and its sign hard to tell.
test::RayCase moved_to_hit(const test::RayCase& given) {
  test::RayCase result = given;
  TriangleHit hit;
  if (!cross(RayShear(given.ray), given.triangle, hit)) return given;
  if (std::isfinite(hit.t)) {
    result.ray.origin = given.ray.origin + given.ray.direction * hit.t;
  }
  return result;
}

class Crossing : public testing::TestWithParam<test::Aim> {
 protected:
  static constexpr int kCases = 400;

  /// Compares with the oracle; returns whether the ray crosses.
  bool check(const test::RayCase& given, int i) {
    const test::ExactCrossing exact = test::exact_crossing(given.ray, given.triangle);
    const RayShear shear(given.ray);
    TriangleHit hit;
    const bool crosses = cross(shear, given.triangle, hit);
    EXPECT_EQ(crosses, exact.crosses) << "seed 31, case " << i;
    if (!crosses || !exact.crosses) return false;
    const int sign = exact.t.numerator.sign();
    EXPECT_EQ(crossing_steps::sign(hit.t), sign) << "seed 31, case " << i << ", t " << hit.t;
    TriangleHit closest;
    EXPECT_TRUE(intersect_exactly(shear, given.triangle, closest)) << "seed 31, case " << i;
    EXPECT_EQ(std::pair(hit.u, hit.v), std::pair(closest.u, closest.v)) << "seed 31, case " << i;
    if (crossing_steps::sign(closest.t) == sign) {
      EXPECT_EQ(hit.t, closest.t) << "seed 31, case " << i;
    } else {
      EXPECT_LE(std::fabs(hit.t), std::numeric_limits<float>::denorm_min());
    }
    return true;
  }
};

TEST_P(Crossing, IsThatOfADisplacedRay) {
  test::Random random(31);
  int crossed = 0;
  for (int i = 0; i < kCases; ++i) {
    const test::RayCase given = test::random_case(random, GetParam());
    crossed += check(given, i);
    crossed += check(moved_to_hit(given), i);
    for (const float factor : {0x1p-140f, 0x1p100f}) {
      check({scaled(given.triangle, factor), scaled(given.ray, factor)}, i);
    }
  }
  const bool is_in_plane =
      GetParam() == test::Aim::grid_in_plane || GetParam() == test::Aim::grid_along_edge;
  if (!is_in_plane) {
    EXPECT_GT(crossed, kCases / 50);
  }
}

INSTANTIATE_TEST_SUITE_P(Aims, Crossing, testing::ValuesIn(test::kAims),
                         [](const auto& aim) { return test::name(aim.param); });

int count_crossings(const Ray& ray, std::initializer_list<Triangle> triangles) {
  int count = 0;
  for (const Triangle& triangle : triangles) {
    TriangleHit hit;
    count += cross(RayShear(ray), triangle, hit) && is_within_limits(ray, hit);
  }
  return count;
}

/// All orders of three corners.
std::array<Triangle, 6> orders(const Triangle& t) {
  return {{{t.p0, t.p1, t.p2},
           {t.p1, t.p2, t.p0},
           {t.p2, t.p0, t.p1},
           {t.p0, t.p2, t.p1},
           {t.p2, t.p1, t.p0},
           {t.p1, t.p0, t.p2}}};
}

TEST(Crossings, OfAnEdgeAreOneWhateverTheOrderOfCorners) {
  const Triangle left{{0, -1, 0}, {0, 1, 0}, {-1, 0, 0.5f}},
      right{{0, -1, 0}, {0, 1, 0}, {1, 0, 0.5f}};
  for (const Vec3 direction : {Vec3{0, 0, 1}, Vec3{0, 0.25f, 1}, Vec3{0, 0, -3}}) {
    const Ray ray{.origin = direction * -2.0f, .direction = direction};
    for (const Triangle& a : orders(left)) {
      for (const Triangle& b : orders(right)) EXPECT_EQ(count_crossings(ray, {a, b}), 1);
    }
  }
}

TEST(Crossings, OfASilhouetteAreNoneOrTwo) {
  const Triangle front{{0, -1, 0}, {0, 1, 0}, {1, 0, 0.5f}}, back{{0, -1, 0}, {0, 1, 0}, {1, 0, 2}};
  for (const float z : {1.0f, -1.0f}) {
    const Ray ray{.origin = {0, 0, -3 * z}, .direction = {0, 0, z}};
    EXPECT_EQ(count_crossings(ray, {front, back}) % 2, 0);
  }
}

TEST(Crossings, OfATriangleSeenEdgeOnAreNone) {
  const Triangle seen{{0, 0, 0}, {1, 0, 1}, {0, 0, 2}};
  EXPECT_EQ(count_crossings({.origin = {0, 0, -1}, .direction = {0, 0, 1}}, {seen}), 0);
  EXPECT_EQ(count_crossings({.origin = {0.5f, 0, -1}, .direction = {0, 0, 1}}, {seen}), 0);
}

TEST(Crossings, AtTheOriginHaveATOfZero) {
  const Triangle triangle{{-1, -1, 0.3f}, {1, -1, 0.3f}, {0, 1, 0.3f}};
  TriangleHit hit;
  ASSERT_TRUE(cross(RayShear({.origin = {0, 0, 0.3f}}), triangle, hit));
  EXPECT_EQ(hit.t, 0.0f);
  const float below = std::nextafter(0.3f, 0.0f), above = std::nextafter(0.3f, 1.0f);
  ASSERT_TRUE(
      cross(RayShear({.origin = {0, 0, below}, .direction = {0, 0, 1e38f}}), triangle, hit));
  EXPECT_GT(hit.t, 0.0f);
  ASSERT_TRUE(
      cross(RayShear({.origin = {0, 0, above}, .direction = {0, 0, 1e38f}}), triangle, hit));
  EXPECT_LT(hit.t, 0.0f);
}

TEST(Crossings, BeyondTheLargestFloatCountBeforeAnInfiniteLimit) {
  const Triangle triangle{{-1, -1, 1}, {1, -1, 1}, {0, 1, 1}};
  Ray ray{.origin = {0, 0, 0}, .direction = {0, 0, 1e-40f}};
  EXPECT_EQ(count_crossings(ray, {triangle}), 1);
  ray.t_max = std::numeric_limits<float>::max();
  EXPECT_EQ(count_crossings(ray, {triangle}), 0);
}

}  // namespace
}  // namespace treelet
