#include <gtest/gtest.h>

#include <treelet/pipeline/build.h>
#include <treelet/query/brute_force.h>

#include <cmath>
#include <string>

#include "support/meshes.h"
#include "support/random.h"

namespace treelet {
namespace {

// The slab test moves far origins to the scene, in doubles: from 2^36 scene sizes away that
// rounding was more than the padding, and hits on vertices were lost.
TEST(Repro, HitsFromVeryFarAway) {
  const test::OwnedMesh mesh = test::icosphere(2);
  test::Random random(11);
  for (const char* const recipe : {"lbvh > bvh2", "lbvh > bvh8"}) {
    const Bvh bvh = build(mesh.view(), recipe);
    for (int i = 0; i < 800; ++i) {
      const Vec3 target = mesh.vertices[random.below(mesh.vertices.size())];
      const Vec3 away = random.point(-1.0f, 1.0f);
      const float distance = std::ldexp(1.0f, 30 + int(random.below(30)));
      Ray ray{.origin = target + away * distance, .direction = away * -1.0f};
      ray.t_min = -std::numeric_limits<float>::infinity();
      ASSERT_EQ(bvh.intersect(ray), intersect_brute_force(mesh.view(), ray))
          << recipe << ", ray " << i << " of seed 11";
    }
  }
}

// One product of an edge function overflowed and its partner did not: the filter saw a certain
// sign.
TEST(Repro, EdgeFunctionsThatOverflowOnOneSide) {
  const test::OwnedMesh mesh = test::scaled(test::triangle_soup(200, 3), 3e19f);
  test::Random random(12);
  for (const char* const recipe : {"lbvh > bvh2", "lbvh > bvh8"}) {
    const Bvh bvh = build(mesh.view(), recipe);
    for (int i = 0; i < 1500; ++i) {
      const Triangle triangle = mesh.view().triangle(random.below(mesh.faces.size()));
      const Vec3 target = i % 2 == 0 ? triangle.p1 : (triangle.p0 + triangle.p2) * 0.5f;
      const Vec3 origin = random.point(-3e19f, 6e19f);
      const Ray ray{.origin = origin, .direction = target - origin};
      ASSERT_EQ(bvh.intersect(ray), intersect_brute_force(mesh.view(), ray))
          << recipe << ", ray " << i << " of seed 12";
    }
  }
}

// With directions of 1e38, t is denormal and its rounding far more than 2^-23 of it.
TEST(Repro, TiesOfDenormalT) {
  const test::OwnedMesh mesh = test::scaled(test::icosphere(2), 1e-3f);
  test::Random random(13);
  for (const char* const recipe : {"lbvh > bvh2", "lbvh > bvh8"}) {
    const Bvh bvh = build(mesh.view(), recipe);
    for (int i = 0; i < 1500; ++i) {
      const Vec3 target = mesh.vertices[random.below(mesh.vertices.size())];
      const Vec3 direction = random.point(-1.0f, 1.0f);
      const Ray ray{.origin = target - direction * 2e-3f, .direction = direction * 1e38f};
      ASSERT_EQ(bvh.intersect(ray), intersect_brute_force(mesh.view(), ray))
          << recipe << ", ray " << i << " of seed 13";
    }
  }
}

}  // namespace
}  // namespace treelet
