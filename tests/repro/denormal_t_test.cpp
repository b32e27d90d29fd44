#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include <treelet/pipeline/build.h>
#include <treelet/query/brute_force.h>

#include "support/meshes.h"
#include "support/random.h"

namespace treelet {
namespace {

constexpr const char* kRecipes[] = {"lbvh > bvh2", "lbvh > bvh8", "lbvh > cwbvh"};

// A t that rounds to zero is within limits that begin there, behind the origin too. Floats excluded
// such hits, for they allowed t to be rounded by a part of itself alone.
TEST(Repro, HitsWhoseTRoundsToZero) {
  const test::OwnedMesh mesh = {{{0, -400, -300}, {0, 500, -300}, {0, 0, 500}}, {{0, 1, 2}}};
  for (const char* const recipe : kRecipes) {
    const Bvh bvh = build(mesh.view(), recipe);
    for (const Vec3 start : {Vec3{1e-38f, 1e8f, 0}, {1e-20f, 1e30f, 0}, {1e-15f, 1e32f, 0}}) {
      const Ray ray{.origin = {start.x, 0, 0}, .direction = {start.y, 0, 0}};
      EXPECT_EQ(bvh.intersect(ray).face, 0) << recipe << ", from " << start.x;
      EXPECT_EQ(bvh.intersect(ray), intersect_brute_force(mesh.view(), ray));
      EXPECT_TRUE(bvh.is_occluded(ray));
    }
  }
}

// The same where t is no normal float: ties and limits are of the rounded ones.
TEST(Repro, TiesAndLimitsWhereTIsNotNormal) {
  constexpr unsigned kSeed = 20;
  const test::OwnedMesh mesh = test::scaled(test::triangle_soup(80, 5), 0x1p-20f);
  test::Random random(kSeed);
  for (const char* const recipe : kRecipes) {
    const Bvh bvh = build(mesh.view(), recipe);
    int hits = 0;
    for (int i = 0; i < 600; ++i) {
      const Triangle triangle = mesh.view().triangle(random.below(mesh.faces.size()));
      const Vec3 origin = random.point(-0x1p-20f, 0x1p-19f), to = triangle.p0 - origin;
      Ray ray{.origin = origin, .direction = to * std::ldexp(1.0f, 110 + int(random.below(30)))};
      const Hit expected = intersect_brute_force(mesh.view(), ray);
      ASSERT_EQ(bvh.intersect(ray), expected) << recipe << ", ray " << i << " of seed " << kSeed;
      if (!expected.is_hit()) continue;
      ++hits;
      ray.t_min = ray.t_max = expected.t;
      ASSERT_EQ(bvh.intersect(ray), expected) << recipe << ", ray " << i << " of seed " << kSeed;
    }
    EXPECT_GT(hits, 100) << recipe;
  }
}

}  // namespace
}  // namespace treelet
