#include <treelet/query/brute_force.h>

#include <gtest/gtest.h>

#include <treelet/pipeline/build.h>

#include <string>
#include <vector>

#include "support/mesh_params.h"
#include "support/mesh_rays.h"
#include "support/meshes.h"
#include "support/recipes.h"

namespace treelet {
namespace {

TEST(BruteForce, TakesTheNearestFaceByHand) {
  test::OwnedMesh mesh;
  for (const float z : {5.0f, 2.0f, 9.0f, 2.0f}) mesh.add({0, 0, z}, {4, 0, z}, {0, 4, z});
  const Mesh view = mesh.view();
  EXPECT_EQ(intersect_brute_force(view, {.origin = {1, 2, 0}}), (Hit{2, 1, 0.25f, 0.5f}));
  EXPECT_EQ(intersect_brute_force(view, {.origin = {1, 2, 0}, .t_min = 3}).face, 0);
  EXPECT_EQ(intersect_brute_force(view, {.origin = {1, 2, 0}, .t_min = 5, .t_max = 5}).face, 0);
  EXPECT_EQ(intersect_brute_force(view, {.origin = {1, 2, 0}, .t_max = 1.5f}), Hit{});
  EXPECT_EQ(intersect_brute_force(view, {.origin = {3, 3, 0}}), Hit{});
}

TEST(BruteForce, LeavesBadFacesOut) {
  const test::OwnedMesh mesh = test::soup_with_bad_faces(600, 3);
  int hits = 0;
  for (const Ray& ray : test::rays_at(mesh.view(), 100, 1)) {
    const Hit hit = intersect_brute_force(mesh.view(), ray);
    if (!hit.is_hit()) continue;
    ++hits;
    EXPECT_EQ(classify(mesh.view().triangle(std::size_t(hit.face))), TriangleKind::regular);
  }
  EXPECT_GT(hits, 100);
}

TEST(BruteForce, RaysThatAreNoRaysMiss) {
  const test::OwnedMesh mesh = test::one_triangle();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(intersect_brute_force(mesh.view(), {.origin = {nan, 0, 0}}), Hit{});
  EXPECT_EQ(intersect_brute_force(mesh.view(), {.direction = {0, 0, 0}}), Hit{});
  EXPECT_EQ(intersect_brute_force(Mesh{}, {}), Hit{});
}

/// What every tree must answer, to the last bit.
class EveryTree : public testing::TestWithParam<test::NamedMesh> {};

TEST_P(EveryTree, AnswersLikeBruteForce) {
  constexpr std::uint64_t kSeed = 42;
  const Mesh mesh = GetParam().mesh.view();
  const std::vector<Ray> rays = test::rays_at(mesh, 60, kSeed);
  std::vector<Hit> expected;
  std::size_t hits = 0;
  for (const Ray& ray : rays) {
    expected.push_back(intersect_brute_force(mesh, ray));
    hits += expected.back().is_hit();
  }
  for (const std::string& recipe : test::every_recipe()) {
    const Bvh bvh = build(mesh, recipe, {.validate = true});
    for (std::size_t i = 0; i < rays.size(); ++i) {
      ASSERT_EQ(bvh.intersect(rays[i]), expected[i])
          << recipe << ", seed " << kSeed << ", ray " << i << ": t " << bvh.intersect(rays[i]).t
          << " instead of " << expected[i].t;
      ASSERT_EQ(bvh.is_occluded(rays[i]), expected[i].is_hit()) << recipe << ", ray " << i;
    }
  }
  if (GetParam().name == "SoupSeed4") {
    EXPECT_GT(hits, rays.size() / 3);
  }
}

INSTANTIATE_TEST_SUITE_P(Meshes, EveryTree, testing::ValuesIn(test::hard_meshes()),
                         test::mesh_name);

}  // namespace
}  // namespace treelet
