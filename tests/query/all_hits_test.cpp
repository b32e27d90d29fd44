#include <treelet/query/all_hits.h>

#include <gtest/gtest.h>

#include <treelet/pipeline/build.h>
#include <treelet/traverse/crossing.h>
#include <treelet/traverse/is_traceable.h>

#include <algorithm>
#include <limits>
#include <string>
#include <tuple>
#include <vector>

#include "support/closed_meshes.h"
#include "support/mesh_rays.h"
#include "support/meshes.h"
#include "support/threads.h"

namespace treelet {
namespace {

std::vector<Hit> brute_force(const Mesh& mesh, const Ray& ray) {
  std::vector<Hit> hits;
  if (!is_traceable(ray)) return hits;
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
    TriangleHit hit;
    if (classify(mesh.triangle(face)) != TriangleKind::regular) continue;
    if (!cross(RayShear(ray), mesh.triangle(face), hit) || !is_within_limits(ray, hit)) continue;
    hits.push_back({hit.t, std::int32_t(face), hit.u, hit.v});
  }
  std::ranges::sort(hits, {}, [](const Hit& hit) { return std::tuple(hit.t, hit.face); });
  return hits;
}

std::vector<std::vector<Hit>> brute_force(const Mesh& mesh, const std::vector<Ray>& rays) {
  std::vector<std::vector<Hit>> rows;
  for (const Ray& ray : rays) rows.push_back(brute_force(mesh, ray));
  return rows;
}

std::vector<std::vector<Hit>> rows_of(const AllHits& all) {
  std::vector<std::vector<Hit>> rows(all.ray_count());
  EXPECT_EQ(all.offsets[0], 0);
  EXPECT_EQ(std::size_t(all.offsets[all.ray_count()]), all.size());
  for (std::size_t ray = 0; ray < rows.size(); ++ray) {
    for (auto i = std::size_t(all.offsets[ray]); i < std::size_t(all.offsets[ray + 1]); ++i) {
      rows[ray].push_back({all.t[i], all.face[i], all.u[i], all.v[i]});
    }
  }
  return rows;
}

class AllHitsOfRays : public testing::TestWithParam<const char*> {
 protected:
  const test::OwnedMesh mesh_ = test::tetrahedra(100, 61);
  const std::vector<Ray> rays_ = test::rays_at(mesh_.view(), 80, 62);
  const std::vector<std::vector<Hit>> expected_ = brute_force(mesh_.view(), rays_);
  const Bvh bvh_ = build(mesh_.view(), GetParam());
};

TEST_P(AllHitsOfRays, AreThoseOfBruteForce) {
  for (const RayOrder order : {RayOrder::given, RayOrder::coherent}) {
    EXPECT_EQ(rows_of(bvh_.intersect_all(RayBatch(rays_), {.order = order})), expected_)
        << "seeds 61, 62";
  }
  for (std::size_t i = 0; i < rays_.size(); i += 10) {
    EXPECT_EQ(bvh_.intersect_all(rays_[i]), expected_[i]) << "seeds 61, 62, ray " << i;
  }
}

TEST_P(AllHitsOfRays, AreTheFirstOnesUpToALimit) {
  for (const std::size_t limit : {1u, 2u, 3u, 40u}) {
    std::vector<std::vector<Hit>> first = expected_;
    for (auto& row : first) row.resize(std::min(row.size(), limit));
    EXPECT_EQ(rows_of(bvh_.intersect_all(RayBatch(rays_), {.limit = limit})), first) << limit;
    EXPECT_EQ(bvh_.intersect_all(rays_[0], {.limit = limit}), first[0]) << limit;
  }
}

TEST_P(AllHitsOfRays, AreTheSameForAnyNumberOfThreads) {
  for (const unsigned threads : {1u, 3u}) {
    const test::ThreadCountScope scope(threads);
    EXPECT_EQ(rows_of(bvh_.intersect_all(RayBatch(rays_))), expected_) << threads << " threads";
  }
}

TEST_P(AllHitsOfRays, OfNothingAreNone) {
  const AllHits of_no_rays = bvh_.intersect_all(RayBatch());
  EXPECT_EQ(of_no_rays.offsets.size(), 1u);
  EXPECT_EQ(of_no_rays.size(), 0u);
  const Bvh empty = build(Mesh{}, GetParam());
  EXPECT_EQ(empty.intersect_all(RayBatch(rays_)).size(), 0u);
  EXPECT_TRUE(empty.intersect_all(rays_[0]).empty());
}

INSTANTIATE_TEST_SUITE_P(Layouts, AllHitsOfRays,
                         testing::Values("lbvh > bvh2", "presplit(budget=80) > lbvh > bvh2(leaf=1)",
                                         "sbvh(budget=80) > bvh8", "lbvh > cwbvh"));

TEST(AllHits, OfManyCoincidentTrianglesAreAllOfThem) {
  const test::OwnedMesh mesh = test::identical_triangles(5000);
  const std::vector<Ray> rays(300, Ray{.origin = {0.25f, 0.25f, -1}});
  const AllHits all = build(mesh.view()).intersect_all(RayBatch(rays));
  ASSERT_EQ(all.size(), 300u * 5000u);
  for (std::size_t i = 0; i < all.size(); ++i) ASSERT_EQ(all.face[i], std::int32_t(i % 5000));
}

TEST(AllHits, BeginWithTheClosestInsideOfTriangles) {
  const test::OwnedMesh mesh = test::triangle_soup(2000, 63);
  const Bvh bvh = build(mesh.view());
  std::size_t hits = 0;
  for (const Ray& ray : test::rays_at(mesh.view(), 200, 64)) {
    const Hit closest = bvh.intersect(ray);
    const bool is_inside = closest.u > 1e-3f && closest.v > 1e-3f && closest.u + closest.v < 0.999f;
    if (!closest.is_hit() || !is_inside) continue;
    const std::vector<Hit> all = bvh.intersect_all(ray, {.limit = 1});
    ASSERT_EQ(all, std::vector<Hit>{closest}) << "seeds 63, 64";
    ++hits;
  }
  EXPECT_GT(hits, 300u);
}

}  // namespace
}  // namespace treelet
