#include <treelet/traverse/ray_box.h>

#include <gtest/gtest.h>

#include <limits>

#include "support/box_rays.h"
#include "support/exact_ray.h"
#include "support/random.h"

namespace treelet {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

BoxSpan span_of(const Ray& ray, const Aabb& box, const Aabb& scene) {
  const RayBox slab(ray, scene);
  return intersect(slab, box, slab.lower_limit(ray.t_min), slab.upper_limit(ray.t_max));
}
bool hits(const Ray& ray, const Aabb& box, const Aabb& scene) {
  return span_of(ray, box, scene).is_hit();
}

class RayBoxScale : public testing::TestWithParam<test::Scale> {};

TEST_P(RayBoxScale, NeverMissesABoxThatTheExactRayMeets) {
  const float factor = GetParam().factor;
  test::Random random(1);
  int met = 0, missed = 0, spurious = 0;
  for (int i = 0; i < 60000 && !HasFailure(); ++i) {
    const Aabb unit_box = test::random_box(random), box = test::scaled(unit_box, factor);
    const Ray ray = test::scaled(test::random_ray_at(random, unit_box), factor);
    if (ray.direction == Vec3{0, 0, 0}) continue;
    const Aabb scene = merge(box, box.lower + (box.upper - box.lower) * 1.5f);
    const bool meets = test::exact_meets_box(ray, box), reported = hits(ray, box, scene);
    EXPECT_TRUE(reported || !meets) << "seed 1, case " << i;
    met += meets;
    missed += !reported;
    spurious += reported && !meets;
  }
  EXPECT_GT(met, 5000);
  EXPECT_GT(missed, 200);
  EXPECT_GT(spurious, 100);  // close calls were among them
}

INSTANTIATE_TEST_SUITE_P(Scales, RayBoxScale,
                         testing::Values(test::Scale{"One", 1.0f}, test::Scale{"Huge", 1e30f},
                                         test::Scale{"Tiny", 1e-30f}),
                         [](const auto& test) { return test.param.name; });

const Aabb kUnit{{0, 0, 0}, {1, 1, 1}};

TEST(RayBox, MeasuresTInPowersOfTwoOfTheDirection) {
  EXPECT_EQ(RayBox({.direction = {0, 3, 0}}, kUnit).t_scale, 2.0);
  EXPECT_EQ(RayBox({.direction = {0, 0, -1}}, kUnit).t_scale, 1.0);
  EXPECT_EQ(RayBox({.direction = {1e-40f, 0, 0}}, kUnit).t_scale, 0x1p-133);
  EXPECT_EQ(RayBox({.direction = {0, 3e38f, 0}}, kUnit).t_scale, 0x1p127);
  const RayBox ray({.direction = {0, 4, 0}}, kUnit);
  EXPECT_FLOAT_EQ(ray.lower_limit(3.0f), 12.0f);
  EXPECT_FLOAT_EQ(ray.upper_limit(3.0f), 12.0f);
  EXPECT_LT(ray.lower_limit(3.0f), 12.0f);
  EXPECT_GT(ray.upper_limit(3.0f), 12.0f);
  EXPECT_LT(ray.lower_limit(-3.0f), -12.0f);
  EXPECT_GT(ray.upper_limit(-3.0f), -12.0f);
  EXPECT_EQ(ray.lower_limit(-kInfinity), -kInfinity);
  EXPECT_EQ(ray.upper_limit(kInfinity), kInfinity);
}

TEST(RayBox, EntersAndLeavesWithinItsPadding) {
  const Ray ray{.origin = {0.5f, 0.5f, -2}, .direction = {0, 0, 1}};
  const BoxSpan span = span_of(ray, kUnit, kUnit);
  EXPECT_LE(span.enter, 2.0f);
  EXPECT_GE(span.leave, 3.0f);
  EXPECT_NEAR(span.enter, 2.0f, 1e-4f);
  EXPECT_NEAR(span.leave, 3.0f, 1e-4f);
}

TEST(RayBox, ClipsToTheLimits) {
  Ray ray{.origin = {0.5f, 0.5f, -2}, .direction = {0, 0, 1}, .t_min = 2.25f, .t_max = 2.5f};
  const BoxSpan span = span_of(ray, kUnit, kUnit);
  EXPECT_FLOAT_EQ(span.enter, 2.25f);
  EXPECT_FLOAT_EQ(span.leave, 2.5f);
  ray.t_max = 1.5f;
  ray.t_min = 0.0f;
  EXPECT_FALSE(hits(ray, kUnit, kUnit));
  ray.t_max = kInfinity;
  ray.t_min = 3.5f;
  EXPECT_FALSE(hits(ray, kUnit, kUnit));
}

TEST(RayBox, MissesWhatIsClearlyBeside) {
  EXPECT_FALSE(hits({.origin = {1.01f, 0.5f, -2}, .direction = {0, 0, 1}}, kUnit, kUnit));
  EXPECT_FALSE(hits({.origin = {1.01f, 0.5f, -2}, .direction = {0, 0, -1}}, kUnit, kUnit));
  EXPECT_FALSE(hits({.origin = {-0.01f, 2, 2}, .direction = {0, -1, -1}}, kUnit, kUnit));
  EXPECT_FALSE(hits({.origin = {0.5f, 0.5f, 2}, .direction = {0, 0, 1}}, kUnit, kUnit));
}

TEST(RayBox, PaddingIsSmallAgainstTheScene) {
  // Between 16 and 40 units of the last place beside a side: a padding a hundred times as large
  // would pass correctness tests and cost a traversal its speed.
  const auto beside = [](float distance) {
    return Ray{.origin = {1.0f + distance, 0.5f, -1}, .direction = {0, 0, 1}};
  };
  EXPECT_TRUE(hits(beside(0x1p-23f), kUnit, kUnit));
  EXPECT_FALSE(hits(beside(0x1p-17f), kUnit, kUnit));
}

TEST(RayBox, NegativeZeroPointsDownAndStillHits) {
  EXPECT_TRUE(hits({.origin = {0, 0.5f, -2}, .direction = {-0.0f, 0.0f, 1}}, kUnit, kUnit));
  EXPECT_TRUE(hits({.origin = {1, 1, -2}, .direction = {-0.0f, -0.0f, 1}}, kUnit, kUnit));
  EXPECT_TRUE(hits({.origin = {1, 1, -2}, .direction = {0.0f, 0.0f, 1}}, kUnit, kUnit));
}

TEST(RayBox, AnEmptyBoxIsMissed) {
  for (const Vec3 direction : {Vec3{0, 0, 1}, Vec3{1, 1, 1}, Vec3{-1, 0, 0}}) {
    const Ray ray{.origin = {0.5f, 0.5f, 0.5f}, .direction = direction};
    EXPECT_FALSE(hits(ray, Aabb::empty(), kUnit));
  }
}

TEST(RayBox, CoordinatesNearTheLargestFloatLoseNothing) {
  const float big = 3e38f;
  const Aabb box{{-big, -big, -big}, {big, big, big}};
  test::Random random(3);
  for (int i = 0; i < 1000; ++i) {
    const Ray ray{.origin = random.point(-1, 1) * big, .direction = random.point(-1, 1)};
    EXPECT_TRUE(hits(ray, box, box)) << "seed 3, case " << i;
  }
}

}  // namespace
}  // namespace treelet
