#include <treelet/traverse/ray_triangle.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "support/exact_ray.h"
#include "support/random.h"
#include "support/ray_cases.h"

namespace treelet {
namespace {

using test::Aim;
using test::RayCase;

float largest_component(Vec3 v) {
  return std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
}

/// The farthest vertex in units of the direction: what rounding in t is measured by.
double reach(const RayCase& c) {
  const Triangle& t = c.triangle;
  const float distance =
      std::max({largest_component(t.p0 - c.ray.origin), largest_component(t.p1 - c.ray.origin),
                largest_component(t.p2 - c.ray.origin)});
  return double(distance) / largest_component(c.ray.direction);
}

/// Compares decision and values with exact arithmetic; returns whether it is a hit.
bool expect_exact(const RayCase& c) {
  const RayShear shear(c.ray);
  const test::ExactHit expected = test::exact_hit(c.ray, c.triangle);
  TriangleHit hit;
  EXPECT_EQ(intersect_exactly(shear, c.triangle, hit), expected.is_hit);
  EXPECT_EQ(intersect(shear, c.triangle, hit), expected.is_hit) << "the filter rejects a hit";
  if (!expected.is_hit) return false;
  // Half a unit for the rounding to float, and next to nothing for what the doubles lost.
  EXPECT_TRUE(test::is_near(hit.t, expected.t, 0x1.1p-24, 0x1p-24 * reach(c))) << hit.t;
  EXPECT_TRUE(test::is_near(hit.u, expected.u, 0x1.1p-24, 0x1p-2)) << hit.u;
  EXPECT_TRUE(test::is_near(hit.v, expected.v, 0x1.1p-24, 0x1p-2)) << hit.v;
  EXPECT_GE(std::min(hit.u, hit.v), 0.0f);
  EXPECT_LE(std::max(hit.u, hit.v), 1.0f);
  EXPECT_FALSE(std::signbit(hit.u) || std::signbit(hit.v)) << "negative zero";
  EXPECT_FALSE(hit.t == 0.0f && std::signbit(hit.t)) << "negative zero";
  return true;
}

class RayTriangle : public testing::TestWithParam<Aim> {};

TEST_P(RayTriangle, DecidesLikeExactArithmetic) {
  constexpr int kCases = 10000;
  int hits = 0;
  test::Random random(100 + std::uint64_t(GetParam()));
  for (int i = 0; i < kCases && !HasFailure(); ++i) {
    SCOPED_TRACE("seed 100 + aim, case " + std::to_string(i));
    hits += expect_exact(random_case(random, GetParam()));
  }
  const bool is_edge_on = GetParam() == Aim::grid_in_plane || GetParam() == Aim::grid_along_edge;
  const bool always_hits = GetParam() == Aim::grid_vertex || GetParam() == Aim::grid_edge;
  EXPECT_EQ(hits == 0, is_edge_on) << hits;
  if (!always_hits) {
    EXPECT_LT(hits, kCases - kCases / 20);
  }
}

TEST_P(RayTriangle, LongAndShortDirectionsScaleTExactly) {
  test::Random random(200 + std::uint64_t(GetParam()));
  for (int i = 0; i < 500 && !HasFailure(); ++i) {
    SCOPED_TRACE("seed 200 + aim, case " + std::to_string(i));
    RayCase c = random_case(random, GetParam());
    TriangleHit hit, scaled;
    const bool is_hit = intersect(RayShear(c.ray), c.triangle, hit);
    for (const int exponent : {-100, -20, 1, 20, 100}) {
      Ray ray = c.ray;
      ray.direction = ray.direction * std::ldexp(1.0f, exponent);
      if (std::ldexp(ray.direction.x, -exponent) != c.ray.direction.x) continue;  // now denormal
      if (std::ldexp(ray.direction.y, -exponent) != c.ray.direction.y) continue;
      if (std::ldexp(ray.direction.z, -exponent) != c.ray.direction.z) continue;
      ASSERT_EQ(intersect(RayShear(ray), c.triangle, scaled), is_hit);
      if (!is_hit) continue;
      EXPECT_EQ(scaled.t, std::ldexp(hit.t, -exponent));
      EXPECT_EQ(scaled.u, hit.u);
      EXPECT_EQ(scaled.v, hit.v);
    }
  }
}

TEST_P(RayTriangle, HugeAndDenormalDirectionsAreExact) {
  test::Random random(300 + std::uint64_t(GetParam()));
  for (int i = 0; i < 1000 && !HasFailure(); ++i) {
    SCOPED_TRACE("seed 300 + aim, case " + std::to_string(i));
    RayCase c = random_case(random, GetParam());
    const bool huge = i % 2 == 0;
    c.ray.direction = c.ray.direction * (huge ? 1e31f : 1e-40f);
    if (c.ray.direction == Vec3{0, 0, 0}) continue;
    TriangleHit hit;
    EXPECT_EQ(intersect(RayShear(c.ray), c.triangle, hit),
              test::exact_hit(c.ray, c.triangle).is_hit);
  }
}

TEST_P(RayTriangle, HugeAndTinyScenesAreExact) {
  test::Random random(400 + std::uint64_t(GetParam()));
  for (int i = 0; i < 1000 && !HasFailure(); ++i) {
    SCOPED_TRACE("seed 400 + aim, case " + std::to_string(i));
    RayCase c = random_case(random, GetParam());
    const float scale = i % 3 == 0 ? 1e30f : i % 3 == 1 ? 1e-30f : 1e-43f;
    Triangle& t = c.triangle;
    t = {t.p0 * scale, t.p1 * scale, t.p2 * scale};
    c.ray.origin = c.ray.origin * scale;
    TriangleHit hit;
    EXPECT_EQ(intersect(RayShear(c.ray), c.triangle, hit),
              test::exact_hit(c.ray, c.triangle).is_hit);
  }
}

TEST_P(RayTriangle, VertexOrderMovesOnlyUAndV) {
  test::Random random(500 + std::uint64_t(GetParam()));
  for (int i = 0; i < 2000 && !HasFailure(); ++i) {
    SCOPED_TRACE("seed 500 + aim, case " + std::to_string(i));
    const RayCase c = random_case(random, GetParam());
    const RayShear shear(c.ray);
    const Triangle& t = c.triangle;
    TriangleHit hit, turned, mirrored;
    const bool is_hit = intersect(shear, t, hit);
    ASSERT_EQ(intersect(shear, {t.p1, t.p2, t.p0}, turned), is_hit);
    ASSERT_EQ(intersect(shear, {t.p0, t.p2, t.p1}, mirrored), is_hit);
    if (!is_hit) continue;
    constexpr float kTolerance = 0x1p-22f;  // sums in another order
    EXPECT_NEAR(turned.u, hit.v, kTolerance);
    EXPECT_NEAR(turned.v, 1.0f - hit.u - hit.v, kTolerance);
    EXPECT_NEAR(mirrored.u, hit.v, kTolerance);
    EXPECT_NEAR(mirrored.v, hit.u, kTolerance);
    EXPECT_NEAR(turned.t, hit.t, kTolerance * reach(c));
    EXPECT_NEAR(mirrored.t, hit.t, kTolerance * reach(c));
  }
}

INSTANTIATE_TEST_SUITE_P(Aims, RayTriangle, testing::ValuesIn(test::kAims),
                         [](const auto& test) { return name(test.param); });

// Neighbours over an edge decide about the same exact line: at least one of them has it.
TEST(RayTriangleEdges, NoRaySlipsThroughASharedEdge) {
  test::Random random(7);
  for (int i = 0; i < 20000 && !HasFailure(); ++i) {
    SCOPED_TRACE("seed 7, case " + std::to_string(i));
    const Vec3 a = random.point(-1.0f, 1.0f), b = random.point(-1.0f, 1.0f);
    const Vec3 left{a.x, a.y + 3.0f, a.z}, right{a.x, a.y - 3.0f, a.z};
    const Vec3 target = a + (b - a) * random.uniform(0.1f, 0.9f);
    Ray ray;
    ray.origin = random.point(-0.5f, 0.5f) + Vec3{0, 0, 5.0f};
    ray.direction = target - ray.origin;
    const RayShear shear(ray);
    TriangleHit hit;
    const bool in_left = intersect(shear, {a, b, left}, hit);
    const bool in_right = intersect(shear, {b, a, right}, hit);
    EXPECT_TRUE(in_left || in_right);
  }
}

TEST(RayTriangleByHand, HitsWhereItShould) {
  const Triangle triangle{{0, 0, 2}, {4, 0, 2}, {0, 4, 2}};
  TriangleHit hit;
  ASSERT_TRUE(intersect(RayShear({.origin = {1, 2, 0}, .direction = {0, 0, 0.5f}}), triangle, hit));
  EXPECT_EQ(hit.t, 4.0f);
  EXPECT_EQ(hit.u, 0.25f);
  EXPECT_EQ(hit.v, 0.5f);
  ASSERT_TRUE(intersect(RayShear({.origin = {1, 2, 3}, .direction = {0, 0, 1}}), triangle, hit));
  EXPECT_EQ(hit.t, -1.0f) << "the whole line counts";
  EXPECT_FALSE(intersect(RayShear({.origin = {3, 2, 0}, .direction = {0, 0, 1}}), triangle, hit));
}

TEST(RayTriangleByHand, VerticesAndEdgesBelongToTheTriangle) {
  const Triangle triangle{{0, 0, 2}, {4, 0, 2}, {0, 4, 2}};
  TriangleHit hit;
  const float points[][4] = {{0, 0, 0, 0},    {4, 0, 1, 0},    {0, 4, 0, 1},
                             {2, 0, 0.5f, 0}, {0, 2, 0, 0.5f}, {2, 2, 0.5f, 0.5f}};
  for (const auto& [x, y, u, v] : points) {
    ASSERT_TRUE(intersect(RayShear({.origin = {x, y, 0}}), triangle, hit)) << x << " " << y;
    EXPECT_EQ(hit.u, u);
    EXPECT_EQ(hit.v, v);
  }
  const float beyond = std::nextafter(0.0f, -1.0f);
  EXPECT_FALSE(intersect(RayShear({.origin = {beyond, 0, 0}}), triangle, hit));
  EXPECT_FALSE(intersect(RayShear({.origin = {2, std::nextafter(2.0f, 3.0f), 0}}), triangle, hit));
}

TEST(RayTriangleByHand, TrianglesWithoutAreaAreNeverHit) {
  test::Random random(9);
  for (int i = 0; i < 20000; ++i) {
    RayCase c = random_case(random, test::kAims[std::size_t(i) % test::kAims.size()]);
    Triangle& t = c.triangle;
    const Vec3 along{float(1 + i % 3), float(i % 5), float(i % 7)};
    t = i % 2 == 0 ? Triangle{t.p0, t.p1, t.p1}
                   : Triangle{along, along * 2.0f, along * 5.0f};  // exactly collinear
    if (i % 4 == 1) c.ray.direction = along * 2.0f - c.ray.origin;
    if (c.ray.direction == Vec3{0, 0, 0}) continue;
    TriangleHit hit;
    ASSERT_FALSE(intersect(RayShear(c.ray), t, hit)) << "seed 9, case " << i;
  }
}

TEST(RayTriangleByHand, AnOverflowOfTIsInfinite) {
  const Triangle triangle{{-1, -1, 2}, {4, -1, 2}, {-1, 4, 2}};
  TriangleHit hit;
  ASSERT_TRUE(
      intersect(RayShear({.origin = {0, 0, 0}, .direction = {0, 0, 1e-40f}}), triangle, hit));
  EXPECT_EQ(hit.t, std::numeric_limits<float>::infinity());
}

// The filter may only reject what the exact test rejects: rays within a few ulps of an edge.
TEST(RayTriangleFilter, SlowNeverRejectsAHit) {
  constexpr Aim aims[] = {Aim::nearby, Aim::vertex, Aim::edge, Aim::far_away, Aim::one_ulp_off};
  test::Random random(11);
  int hits = 0, rejected = 0;
  for (int i = 0; i < 3000000; ++i) {
    RayCase c = random_case(random, aims[i % 5]);
    const float scale = i % 7 == 0 ? 1e18f : i % 7 == 1 ? 1e-18f : i % 7 == 2 ? 1e-40f : 1.0f;
    Triangle& t = c.triangle;
    t = {t.p0 * scale, t.p1 * scale, t.p2 * scale};
    c.ray.origin = c.ray.origin * scale;
    const RayShear shear(c.ray);
    TriangleHit hit;
    const bool may = may_intersect(shear, t), is_hit = intersect_exactly(shear, t, hit);
    ASSERT_TRUE(may || !is_hit) << "seed 11, case " << i;
    hits += is_hit;
    rejected += !may;
  }
  EXPECT_GT(hits, 500000);
  EXPECT_GT(rejected, 300000);
}

TEST(RayTriangleFilter, RejectsNearlyAllMisses) {
  test::Random random(12);
  int misses = 0, rejected = 0;
  for (int i = 0; i < 20000; ++i) {
    const RayCase c = random_case(random, Aim::nearby);
    TriangleHit hit;
    if (intersect_exactly(RayShear(c.ray), c.triangle, hit)) continue;
    ++misses;
    rejected += !may_intersect(RayShear(c.ray), c.triangle);
  }
  EXPECT_GT(rejected, misses - misses / 1000);
}

TEST(RayTriangleFilter, OverflowRejectsNothing) {
  const float big = 3e38f;
  const Triangle triangle{{-big, -big, big}, {big, -big, big}, {0, big, big}};
  TriangleHit hit;
  const RayShear shear({.origin = {0, 0, -big}, .direction = {0, 0, 1}});
  EXPECT_TRUE(may_intersect(shear, triangle));
  ASSERT_TRUE(intersect(shear, triangle, hit));
  EXPECT_EQ(hit.t, std::numeric_limits<float>::infinity());  // 6e38
}

// Nearly edge-on, weights are small differences of large products; t must not suffer.
TEST(RayTriangleEdgeOn, KeepsItsAccuracy) {
  test::Random random(13);
  const auto whole = [&](int most) { return float(int(random.below(2 * most + 1)) - most); };
  int hits = 0;
  for (int i = 0; i < 30000 && !HasFailure(); ++i) {
    SCOPED_TRACE("seed 13, case " + std::to_string(i));
    const float p = whole(8000), q = whole(8000);
    const auto in_plane = [&](float a, float b) { return Vec3{a, b, a * p + b * q}; };
    RayCase c;
    c.triangle = {in_plane(whole(64), whole(64)), in_plane(whole(64), whole(64)),
                  in_plane(whole(64), whole(64))};
    c.ray.origin = in_plane(whole(64), whole(64)) + Vec3{0, 0, whole(1)};
    c.ray.direction = in_plane(whole(1600), whole(1600)) + Vec3{0, 0, 1};
    const test::ExactHit expected = test::exact_hit(c.ray, c.triangle);
    TriangleHit hit;
    ASSERT_EQ(intersect(RayShear(c.ray), c.triangle, hit), expected.is_hit);
    if (!expected.is_hit) continue;
    ++hits;
    EXPECT_TRUE(test::is_near(hit.t, expected.t, 0x1p-23, reach(c)));
    EXPECT_TRUE(test::is_near(hit.u, expected.u, 0x1p-23, 1.0));
  }
  EXPECT_GT(hits, 500);
}

}  // namespace
}  // namespace treelet
