#include <treelet/traverse/ray_triangle.h>

#include <gtest/gtest.h>

#include "support/exact_ray.h"

namespace treelet {
namespace {

// A ray 2^-32 from edge-on. The signs of the edge functions were beyond doubt in doubles and their
// values were not: t was off by more than boxes are padded for, so a tree could lose the hit.
TEST(Repro, HitDistanceOfATriangleSeenNearlyEdgeOn) {
  const Triangle triangle{{-48, -58, -709894}, {57, -43, -38464}, {28, 4, 179048}};
  const Ray ray{.origin = {-14, -52, -483474}, .direction = {-1223, 817, -6843}};
  const double to_farthest_vertex = 179048.0 + 483474.0, largest_component = 6843.0;

  TriangleHit hit;
  ASSERT_TRUE(intersect(RayShear(ray), triangle, hit));
  const test::ExactHit expected = test::exact_hit(ray, triangle);
  ASSERT_TRUE(expected.is_hit);
  EXPECT_TRUE(test::is_near(hit.t, expected.t, 0x1p-23, to_farthest_vertex / largest_component));
  EXPECT_TRUE(test::is_near(hit.u, expected.u, 0x1p-23, 1.0));
  EXPECT_TRUE(test::is_near(hit.v, expected.v, 0x1p-23, 1.0));
}

}  // namespace
}  // namespace treelet
