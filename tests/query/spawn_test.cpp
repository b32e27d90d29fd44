#include <treelet/query/spawn.h>

#include <gtest/gtest.h>

#include <treelet/traverse/crossing.h>
#include <treelet/traverse/face_filter.h>
#include <treelet/traverse/ray_triangle.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "support/random.h"

namespace treelet {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();

/// Whether a ray from t = 0 on reports the triangle, as the closest hit or in a list.
bool meets(const Ray& ray, const Triangle& triangle) {
  const RayShear shear(ray);
  TriangleHit hit;
  if (intersect_exactly(shear, triangle, hit) && hit.t >= 0.0f) return true;
  return cross(shear, triangle, hit) && hit.t >= 0.0f;
}

/// A triangle of any size, shape and place.
Triangle random_triangle(test::Random& random) {
  const float size = std::ldexp(1.0f, int(random.below(180)) - 90);
  const float far = random.below(2) == 0 ? 0.0f : std::ldexp(1.0f, int(random.below(24)));
  const Vec3 place = random.point(-far, far), way = random.point(-1, 1);
  const float width = std::ldexp(1.0f, -int(random.below(24)));
  const Vec3 corners[] = {place, place + way,
                          place + way * random.uniform(-1, 2) + random.point(-width, width)};
  return {corners[0] * size, corners[1] * size, corners[2] * size};
}

Vec3 random_direction(test::Random& random, const Triangle& t) {
  const float size = std::ldexp(1.0f, int(random.below(60)) - 30);
  const Vec3 along = (t.p1 - t.p0) * random.uniform(-1, 1) + (t.p2 - t.p0) * random.uniform(-1, 1);
  const float length = max_component({std::fabs(along.x), std::fabs(along.y), std::fabs(along.z)});
  switch (random.below(3)) {
    case 0:
      return random.point(-1, 1) * size;
    case 1:  // grazing by what rounding leaves
      return length > 0.0f ? along * (size / length) : Vec3{size, 0, 0};
    default:
      return (length > 0.0f ? along * (1 / length) : Vec3{1, 0, 0}) * size +
             random.point(-1e-6f, 1e-6f) * size;
  }
}

TEST(SpawnOrigin, IsWhereRaysDoNotMeetTheTriangleAgain) {
  test::Random random(41);
  int met_from_the_point = 0;
  for (int i = 0; i < 1000000; ++i) {
    const Triangle t = random_triangle(random);
    if (classify(t) != TriangleKind::regular) continue;
    float u = random.uniform(0, 1), v = random.uniform(0, 1);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    if (i % 7 == 0) u = 0;
    if (i % 11 == 0) v = 0;
    const Vec3 direction = random_direction(random, t);
    if (direction == Vec3{0, 0, 0}) continue;
    const Vec3 origin = spawn_origin(t, u, v, direction);
    ASSERT_FALSE(meets({origin, direction, 0, kInf}, t)) << "seed 41, case " << i;
    const Vec3 point = t.p0 + (t.p1 - t.p0) * u + (t.p2 - t.p0) * v;
    met_from_the_point += meets({point, direction, 0, kInf}, t);
  }
  EXPECT_GT(met_from_the_point, 50000);  // else the test cannot fail
}

/// Directions so long that t, counted in them, is next to nothing.
TEST(SpawnOrigin, IsFarEnoughForHugeDirectionsAndTinyTriangles) {
  test::Random random(42);
  for (int i = 0; i < 100000; ++i) {
    const float size = std::ldexp(1.0f, -100 - int(random.below(46)));
    const Triangle t{random.point(-1, 1) * size, random.point(-1, 1) * size,
                     random.point(-1, 1) * size};
    if (classify(t) != TriangleKind::regular) continue;
    const Vec3 direction = random.point(-1, 1) * (i % 2 == 0 ? 1e30f : 1.0f);
    ASSERT_FALSE(meets({spawn_origin(t, 0.25f, 0.25f, direction), direction, 0, kInf}, t))
        << "seed 42, case " << i;
  }
}

/// Where floats are so dense that rounding the origin moves it by next to nothing, and slivers make
/// t as inexact as it gets.
TEST(SpawnOrigin, IsFarEnoughForSliversThroughZero) {
  test::Random random(46);
  for (int i = 0; i < 1000000; ++i) {
    const Vec3 way = random.point(-1, 1);
    const float width = std::ldexp(1.0f, -int(random.below(26)));
    const float along = random.uniform(-1, 1), v = random.uniform(0, 0.3f);
    const Triangle t{Vec3{0, 0, 0} - way, way, way * along + random.point(-width, width)};
    if (classify(t) != TriangleKind::regular) continue;
    const Vec3 direction = random.point(-1, 1);
    const Vec3 origin = spawn_origin(t, 0.5f * (1 - v * (1 + along)), v, direction);
    ASSERT_FALSE(meets({origin, direction, 0, kInf}, t)) << "seed 46, case " << i;
  }
}

TEST(SpawnOrigin, StaysNearThePoint) {
  test::Random random(43);
  for (int i = 0; i < 100000; ++i) {
    const float far = std::ldexp(1.0f, int(random.below(20)));
    const Vec3 place = random.point(-far, far);
    const Triangle t{place + random.point(-1, 1), place + random.point(-1, 1),
                     place + random.point(-1, 1)};
    const Vec3 origin = spawn_origin(t, 0.25f, 0.5f, random.point(-1, 1));
    for (int k = 0; k < 3; ++k) {
      const double point = 0.25 * t.p0[k] + 0.25 * t.p1[k] + 0.5 * t.p2[k];
      const double room = 0x1p-20 + 0x1p-23 * std::fabs(point);
      ASSERT_NEAR(origin[k], point, room) << "seed 43, case " << i;
    }
  }
}

TEST(SpawnOrigin, GoesThroughDoublesAndBack) {
  test::Random random(44);
  for (int i = 0; i < 100000; ++i) {
    const double far = std::ldexp(1.0 + random.uniform(0, 1), int(random.below(30)));
    const Triangle t{random.point(-1, 1), random.point(-1, 1), random.point(-1, 1)};
    const Vec3 direction = random_direction(random, t);
    if (direction == Vec3{0, 0, 0}) continue;
    const Vec3 local = spawn_origin(t, 0.3f, 0.3f, direction, far);
    const auto through = [&](float x) { return float((double(x) + far) - far); };
    const Vec3 origin{through(local.x), through(local.y), through(local.z)};
    ASSERT_FALSE(meets({origin, direction, 0, kInf}, t)) << "seed 44, case " << i;
  }
}

TEST(UnitNormal, PointsToWhereCornersTurnCounterClockwise) {
  EXPECT_EQ(unit_normal({{0, 0, 5}, {3, 0, 5}, {0, 4, 5}}), (Vec3{0, 0, 1}));
  EXPECT_EQ(unit_normal({{0, 0, 5}, {0, 4, 5}, {3, 0, 5}}), (Vec3{0, 0, -1}));
}

TEST(UnitNormal, HasLengthOneForTrianglesOfAllSizesAndShapes) {
  test::Random random(45);
  for (int i = 0; i < 100000; ++i) {
    const Triangle t = random_triangle(random);
    const Vec3 normal = unit_normal(t);
    if (normal.x != normal.x) continue;  // its corners are on a line
    const double length = std::sqrt(double(normal.x) * normal.x + double(normal.y) * normal.y +
                                    double(normal.z) * normal.z);
    ASSERT_NEAR(length, 1.0, 1e-6) << "seed 45, case " << i;
    ASSERT_GE(side_of(normal, t), 0) << "seed 45, case " << i;
  }
}

TEST(UnitNormal, OfATriangleWithoutAreaIsNaN) {
  EXPECT_TRUE(std::isnan(unit_normal({{0, 0, 0}, {1, 1, 1}, {3, 3, 3}}).x));
}

}  // namespace
}  // namespace treelet
