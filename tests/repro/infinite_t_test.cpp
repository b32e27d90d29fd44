#include <gtest/gtest.h>

#include <limits>

#include <treelet/pipeline/build.h>
#include <treelet/query/brute_force.h>

#include "support/meshes.h"
#include "support/random.h"

namespace treelet {
namespace {

// A t below the least float is minus infinity. As a limit it became NaN in the slab test, which
// then missed the boxes of equal hits, of which the smaller face should win.
TEST(Repro, TiesOfHitsBeforeTheLeastFloat) {
  constexpr float inf = std::numeric_limits<float>::infinity();
  const test::OwnedMesh mesh = test::scaled(test::triangle_soup(60, 3), 100.0f);
  test::Random random(14);
  for (const char* const recipe : {"lbvh > bvh2", "lbvh > bvh8", "lbvh > cwbvh"}) {
    const Bvh bvh = build(mesh.view(), recipe);
    int at_infinity = 0;
    for (int i = 0; i < 400; ++i) {
      const Triangle triangle = mesh.view().triangle(random.below(mesh.faces.size()));
      const Vec3 origin = random.point(-100.0f, 200.0f), away = origin - triangle.p0;
      const Ray ray{.origin = origin, .direction = away * 1e-42f, .t_min = -inf, .t_max = 9.0f};
      ASSERT_EQ(bvh.intersect(ray), intersect_brute_force(mesh.view(), ray))
          << recipe << ", ray " << i << " of seed 14";
      at_infinity += bvh.intersect(ray).t == -inf;
    }
    EXPECT_GT(at_infinity, 100) << recipe;
  }
}

}  // namespace
}  // namespace treelet
