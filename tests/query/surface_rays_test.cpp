#include <treelet/query/surface_rays.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "support/meshes.h"
#include "support/threads.h"

namespace treelet {
namespace {

double length(Vec3 v) {
  return std::sqrt(double(v.x) * v.x + double(v.y) * v.y + double(v.z) * v.z);
}

TEST(SurfaceRays, LeaveBothSidesOfASquareEvenly) {
  const test::OwnedMesh mesh = test::coplanar_grid(7);
  const std::vector<Ray> rays = make_surface_rays(mesh.view(), 20000);
  ASSERT_NEAR(double(rays.size()), 20000.0, 1.0);
  double up = 0.0, cosine = 0.0, left = 0.0;
  for (const Ray& ray : rays) {
    ASSERT_EQ(ray.origin.z > 0.0f, ray.direction.z > 0.0f);
    ASSERT_NE(ray.origin.z, 0.0f);
    EXPECT_LT(std::abs(ray.origin.z), 1e-3f);
    up += ray.direction.z > 0.0f;
    left += ray.origin.x < 0.25f && ray.origin.y < 0.5f;
    cosine += std::abs(ray.direction.z) / length(ray.direction);
  }
  const double count = double(rays.size());
  EXPECT_NEAR(up / count, 0.5, 0.02);
  EXPECT_NEAR(left / count, 0.125, 0.01);
  EXPECT_NEAR(cosine / count, 2.0 / 3.0, 0.01);  // of a cosine distribution
}

TEST(SurfaceRays, GoByArea) {
  test::OwnedMesh mesh = test::two_triangles();
  mesh.add({10, 0, 0}, {13, 0, 0}, {10, 2, 0});  // three times the area of the square
  std::size_t right = 0;
  const std::vector<Ray> rays = make_surface_rays(mesh.view(), 1000);
  for (const Ray& ray : rays) right += ray.origin.x > 5.0f;
  EXPECT_NEAR(double(right), 750.0, 1.0);
}

TEST(SurfaceRays, AreFiniteAtAnyScale) {
  for (const float scale : {1e-30f, 1.0f, 1e30f}) {
    const test::OwnedMesh mesh = test::scaled(test::triangle_soup(500, 3), scale);
    const std::vector<Ray> rays = make_surface_rays(mesh.view(), 1000);
    ASSERT_NEAR(double(rays.size()), 1000.0, 1.0) << scale;
    for (const Ray& ray : rays) {
      ASSERT_TRUE(is_finite(ray.origin) && is_finite(ray.direction)) << scale;
      ASSERT_GT(length(ray.direction), 0.0) << scale;
    }
  }
}

TEST(SurfaceRays, PassBadTrianglesOver) {
  const test::OwnedMesh bad = test::soup_with_bad_faces(600, 4);
  for (const Ray& ray : make_surface_rays(bad.view(), 5000)) ASSERT_TRUE(is_finite(ray.origin));
  EXPECT_TRUE(make_surface_rays(test::degenerate_triangles(5).view(), 100).empty());
  EXPECT_TRUE(make_surface_rays(test::empty_mesh().view(), 100).empty());
}

TEST(SurfaceRays, AreTheSameForAnyNumberOfThreads) {
  const test::OwnedMesh mesh = test::triangle_soup(100000, 5);
  const std::vector<Ray> expected = make_surface_rays(mesh.view(), 3000);
  ASSERT_GT(expected.size(), 2990u);
  for (const unsigned threads : {1u, 2u, 5u}) {
    const test::ThreadCountScope scope(threads);
    const std::vector<Ray> rays = make_surface_rays(mesh.view(), 3000);
    ASSERT_EQ(rays.size(), expected.size());
    for (std::size_t i = 0; i < rays.size(); ++i) {
      ASSERT_EQ(rays[i].origin, expected[i].origin) << threads << " threads, ray " << i;
      ASSERT_EQ(rays[i].direction, expected[i].direction) << threads << " threads, ray " << i;
      ASSERT_NE(rays[i].direction, (Vec3{0, 0, 1})) << "no ray was written to place " << i;
    }
  }
}

}  // namespace
}  // namespace treelet
