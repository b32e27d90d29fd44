#include <treelet/query/hit_counts.h>

#include <gtest/gtest.h>

#include <treelet/pipeline/build.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "support/closed_meshes.h"
#include "support/errors.h"
#include "support/exact_crossing.h"
#include "support/mesh_params.h"
#include "support/mesh_rays.h"
#include "support/random.h"
#include "support/threads.h"

namespace treelet {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();

std::vector<std::int64_t> counts_of(const Bvh& bvh, const std::vector<Ray>& rays) {
  std::vector<std::int64_t> counts(rays.size());
  bvh.count_hits(RayBatch(rays), counts);
  return counts;
}

Aabb bounds_of(const Mesh& mesh) {
  Aabb box = Aabb::empty();
  for (const Vec3 vertex : mesh.vertices) box = merge(box, vertex);
  return box;
}

/// Rays that start outside of the mesh's box and aim exactly, or as exactly as floats let them, at
/// vertices, edges and insides of triangles, or anywhere.
std::vector<Ray> rays_from_outside(const Mesh& mesh, std::size_t count, std::uint64_t seed) {
  test::Random random(seed);
  const Aabb box = bounds_of(mesh);
  const Vec3 extent = box.extent();
  std::vector<Ray> rays(count);
  for (std::size_t i = 0; i < count; ++i) {
    const Triangle t = mesh.triangle(random.below(mesh.faces.size()));
    const Vec3 on_edge = t.p0 + (t.p1 - t.p0) * 0.5f;
    const Vec3 inside = on_edge + (t.p2 - on_edge) * random.uniform(0.0f, 1.0f);
    const Vec3 target = i % 4 == 0 ? t.p0 : i % 4 == 1 ? on_edge : inside;
    const std::uint64_t axis = random.below(3);
    Vec3 way = random.point(-1.0f, 1.0f);
    if (i % 3 == 0)
      way = {axis == 0 ? 1.0f : 0.0f, axis == 1 ? 1.0f : 0.0f, axis == 2 ? 1.0f : 0.0f};
    if (i % 3 == 1) way = t.p1 == t.p0 ? way : t.p1 - t.p0;
    const float length = std::max({std::fabs(way.x), std::fabs(way.y), std::fabs(way.z)});
    way = way * (2.0f / length) * max_component(extent);
    rays[i].origin = target - way;
    rays[i].direction = i % 5 == 0 ? way : target - rays[i].origin;
    if (rays[i].direction == Vec3{0, 0, 0}) rays[i].direction = {1, 0, 0};
  }
  return rays;
}

class Parity : public testing::TestWithParam<test::NamedMesh> {
 protected:
  const test::OwnedMesh& mesh_ = GetParam().mesh;
};

TEST_P(Parity, IsEvenFromOutside) {
  const std::vector<Ray> rays = rays_from_outside(mesh_.view(), 4000, 51);
  for (const char* const recipe : {"balanced", "lbvh > bvh2", "lbvh > cwbvh", "sbvh > bvh8"}) {
    const auto counts = counts_of(build(mesh_.view(), recipe), rays);
    std::int64_t hits = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      ASSERT_EQ(counts[i] % 2, 0) << recipe << ", seed 51, ray " << i;
      hits += counts[i];
    }
    EXPECT_GT(hits, 2000) << recipe;
  }
}

/// A point is inside or not, whatever the direction that asks: from points near the surface, on the
/// float grid beside it and far away.
TEST_P(Parity, OfAPointIsTheSameInAllDirections) {
  test::Random random(52);
  const Bvh bvh = build(mesh_.view());
  const Aabb box = bounds_of(mesh_.view());
  int inside = 0, outside = 0;
  for (int i = 0; i < 300; ++i) {
    const Triangle t = mesh_.view().triangle(random.below(mesh_.faces.size()));
    Vec3 point = i % 3 == 0 ? t.p0 : (t.p0 + t.p1) * 0.5f;
    if (i % 3 == 2) point = box.lower + box.extent() * random.uniform(0.0f, 1.0f);
    for (float* const x : {&point.x, &point.y, &point.z}) {
      const std::uint64_t way = random.below(3);
      if (way > 0) *x = std::nextafter(*x, way == 1 ? -kInf : kInf);
    }
    int odd = 0, on_surface = 0, asked = 0;
    for (int k = 0; k < 8; ++k) {
      Ray ray{.origin = point, .direction = random.point(-1.0f, 1.0f)};
      if (k < 3)
        ray.direction = {k == 0 ? 1e-30f : 0.0f, k == 1 ? -1.0f : 0.0f, k == 2 ? 1e30f : 0.0f};
      ++asked;
      odd += bvh.count_hits(ray) % 2 != 0;
      ray.t_max = 0.0f;  // t is zero on the surface alone, its sign exact
      on_surface += bvh.count_hits(ray) != 0;
    }
    if (on_surface > 0) continue;
    EXPECT_TRUE(odd == 0 || odd == asked) << "seed 52, point " << i << ": " << odd;
    ++(odd == 0 ? outside : inside);
  }
  EXPECT_GT(outside, 5);
  EXPECT_GT(inside + outside, 50);
}

TEST_P(Parity, CountsAreThoseOfExactArithmetic) {
  const Bvh bvh = build(mesh_.view(), "sbvh(budget=50) > bvh8");
  std::vector<Ray> rays = rays_from_outside(mesh_.view(), 8, 53);
  const std::vector<Ray> others = test::rays_at(mesh_.view(), 2, 54);
  rays.insert(rays.end(), others.begin(), others.end());
  for (std::size_t i = 0; i < rays.size(); ++i) {
    Ray& ray = rays[i];
    ray.t_min = 0.0f, ray.t_max = kInf;
    const Triangle t = mesh_.view().triangle(i % mesh_.faces.size());
    if (i % 4 == 3) ray.origin = t.p0 + (t.p1 - t.p0) * 0.375f;  // near the surface or on it
    ASSERT_EQ(bvh.count_hits(ray), test::count_exact_crossings(ray, mesh_.view()))
        << "seeds 53 and 54, ray " << i;
  }
}

INSTANTIATE_TEST_SUITE_P(ClosedMeshes, Parity, testing::ValuesIn(test::closed_meshes()),
                         test::mesh_name);

TEST(Parities, SlowAMillionRaysAreNeverOddFromOutside) {
  for (const test::NamedMesh& closed : test::closed_meshes()) {
    const std::vector<Ray> rays = rays_from_outside(closed.mesh.view(), 90000, 55);
    const auto counts = counts_of(build(closed.mesh.view()), rays);
    std::size_t odd = 0;
    for (const std::int64_t count : counts) odd += count % 2 != 0;
    EXPECT_EQ(odd, 0u) << closed.name << ", seed 55";
  }
}

TEST(Parities, OfAnOpenMeshAreOddNowAndThen) {  // the tests above can fail
  test::OwnedMesh mesh = test::torus(32, 16);
  mesh.faces.pop_back();
  std::size_t odd = 0;
  const std::vector<Ray> rays = rays_from_outside(mesh.view(), 4000, 56);
  for (const std::int64_t count : counts_of(build(mesh.view()), rays)) odd += count % 2 != 0;
  EXPECT_GT(odd, 4u);
}

TEST(HitCounts, CountAFaceOnce) {
  const test::OwnedMesh mesh = test::stacked_cubes(4);
  const Bvh bvh = build(mesh.view(), "presplit(budget=100) > lbvh > bvh2(leaf=1)");
  ASSERT_GT(bvh.report.references, mesh.faces.size());
  EXPECT_EQ(bvh.count_hits({.origin = {0.3f, 0.4f, -1}, .direction = {0, 0, 1}}), 8);
  EXPECT_EQ(bvh.count_hits({.origin = {0.5f, 0.5f, -1}, .direction = {0, 0, 1}}), 8);
  EXPECT_EQ(bvh.count_hits({.origin = {0.5f, 0.5f, 0.5f}, .direction = {0, 0, 1}}), 7);
}

TEST(HitCounts, FromTheSurfaceAreThoseFromJustBefore) {
  const Bvh bvh = build(test::cube().view());
  EXPECT_EQ(bvh.count_hits({.origin = {0.3f, 0.4f, 0}, .direction = {0, 0, 1}}), 2);
  EXPECT_EQ(bvh.count_hits({.origin = {0.3f, 0.4f, 0}, .direction = {0, 0, -1}}), 1);
}

TEST(HitCounts, OfBadRaysAndEmptyTreesAreZero) {
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<Ray> rays{{.direction = {0, 0, 0}}, {.t_min = nan},          {.t_max = nan},
                              {.t_min = 2, .t_max = 1}, {.origin = {nan, 0, 0}}, {}};
  for (const char* const recipe : {"lbvh > bvh2", "lbvh > bvh8", "lbvh > cwbvh"}) {
    const std::vector<std::int64_t> expected{0, 0, 0, 0, 0, 2};
    const test::OwnedMesh mesh = test::translated(test::cube(), {-0.5f, -0.5f, 1});
    EXPECT_EQ(counts_of(build(mesh.view(), recipe), rays), expected) << recipe;
    EXPECT_EQ(counts_of(build(Mesh{}, recipe), rays), std::vector<std::int64_t>(6, 0)) << recipe;
  }
}

TEST(HitCounts, AreTheSameForAnyNumberOfThreads) {
  const test::OwnedMesh mesh = test::tetrahedra(300, 57);
  const Bvh bvh = build(mesh.view());
  const std::vector<Ray> rays = rays_from_outside(mesh.view(), 5000, 58);
  const auto expected = counts_of(bvh, rays);
  for (const unsigned threads : {1u, 3u}) {
    const test::ThreadCountScope scope(threads);
    EXPECT_EQ(counts_of(bvh, rays), expected) << threads << " threads";
  }
}

TEST(HitCounts, RefuseTooLittleRoom) {
  const Bvh bvh = build(test::cube().view());
  const std::vector<Ray> rays(3);
  std::int64_t counts[2];
  EXPECT_EQ(test::error_of([&] { bvh.count_hits(RayBatch(rays), counts); }),
            "there is room for 2 counts of 3 rays");
}

}  // namespace
}  // namespace treelet
