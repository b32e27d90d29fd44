#include <treelet/query/device_all_hits.h>

#include <gtest/gtest.h>

#include <treelet/pipeline/build.h>
#include <treelet/pipeline/device_bvh.h>
#include <treelet/query/hit_counts.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "cuda/deep_trees.h"
#include "cuda/device_hit_lists.h"
#include "cuda/device_input.h"
#include "cuda/device_rays.h"
#include "cuda/schedules.h"
#include "support/aimed_rays.h"
#include "support/closed_meshes.h"
#include "support/mesh_params.h"
#include "support/mesh_rays.h"
#include "support/meshes.h"
#include "support/ray_cases.h"

namespace treelet {
namespace {

using test::count_hits;
using test::kStream;
using test::list_hits;
using test::lists_of;

/// All layouts, with whole faces and with split ones.
constexpr const char* kRecipes[] = {"lbvh > bvh2",
                                    "lbvh > bvh8",
                                    "lbvh > cwbvh",
                                    "presplit(budget=80) > lbvh > bvh2(leaf=1)",
                                    "sbvh(budget=80) > bvh8",
                                    "presplit(budget=80) > lbvh > cwbvh"};

void expect_the_hosts_lists(const Bvh& host, const std::vector<Ray>& rays,
                            const std::string& what) {
  const cuda::DeviceBvh bvh = cuda::DeviceBvh::upload(host, kStream);
  const test::DeviceRays device_rays(rays);
  const test::HitLists expected = lists_of(host.intersect_all(RayBatch(rays)));
  EXPECT_EQ(list_hits(bvh, device_rays.batch()), expected) << what;
  std::vector<std::int64_t> counts(rays.size());
  host.count_hits(RayBatch(rays), counts);
  EXPECT_EQ(count_hits(bvh, device_rays.batch()), counts) << what;
}

class DeviceAllHitsOf : public testing::TestWithParam<test::NamedMesh> {};

TEST_P(DeviceAllHitsOf, AreTheHostsInEveryLayout) {
  const Mesh mesh = GetParam().mesh.view();
  const std::vector<Ray> rays = test::rays_at(mesh, 8, 31);
  std::uint64_t schedule = 0;
  for (const char* recipe : kRecipes) {
    const Bvh host = build(mesh, recipe);
    test::with_schedule(schedule++ % 4, [&] { expect_the_hosts_lists(host, rays, recipe); });
  }
}

INSTANTIATE_TEST_SUITE_P(HardMeshes, DeviceAllHitsOf, testing::ValuesIn(test::hard_meshes()),
                         test::mesh_name);

class DeviceAllHits : public testing::TestWithParam<const char*> {
 protected:
  const test::OwnedMesh mesh_ = test::tetrahedra(60, 61);
  const std::vector<Ray> rays_ = test::rays_at(mesh_.view(), 20, 62);
  const Bvh host_ = build(mesh_.view(), GetParam());
  const cuda::DeviceBvh bvh_ = cuda::DeviceBvh::upload(host_, kStream);
};

TEST_P(DeviceAllHits, OfRaysThatGrazeAreTheHosts) {
  for (const test::Aim aim : test::kAims) {
    const auto [mesh, rays] = test::AimedRays(aim, 100, 8);
    expect_the_hosts_lists(build(mesh.view(), GetParam()), rays, test::name(aim) + ", seed 8");
  }
}

TEST_P(DeviceAllHits, OfBadRaysAreNone) {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  std::vector<Ray> rays(8, rays_[0]);
  rays[0].origin.x = kNaN;
  rays[1].direction.y = kInfinity;
  rays[2].direction = {0, 0, 0};
  rays[3].t_min = kNaN;
  rays[4].t_max = kNaN;
  rays[5].t_min = 2.0f, rays[5].t_max = 1.0f;
  rays[6].t_min = -kInfinity;
  expect_the_hosts_lists(host_, rays, GetParam());
}

TEST_P(DeviceAllHits, AreTheFirstOnesUpToALimit) {
  const test::DeviceRays rays(rays_);
  for (const std::uint32_t limit : {1u, 2u, 3u, 40u}) {
    EXPECT_EQ(list_hits(bvh_, rays.batch(), limit),
              lists_of(host_.intersect_all(RayBatch(rays_), {.limit = limit})))
        << limit;
  }
}

TEST_P(DeviceAllHits, AreTheSameInEveryOrderOfRaysAndThreads) {
  const test::DeviceRays rays(rays_);
  const test::HitLists expected = lists_of(host_.intersect_all(RayBatch(rays_)));
  test::for_each_schedule([&](std::uint64_t seed) {
    EXPECT_EQ(list_hits(bvh_, rays.batch(), test::kNoLimit, RayOrder::coherent), expected) << seed;
  });
  EXPECT_EQ(count_hits(bvh_, rays.batch(), RayOrder::coherent), count_hits(bvh_, rays.batch()));
}

TEST_P(DeviceAllHits, OfManyCoincidentTrianglesAreAllOfThem) {
  const test::OwnedMesh mesh = test::identical_triangles(700);
  const std::vector<Ray> rays(5, Ray{.origin = {0.25f, 0.25f, -1}});
  const Bvh host = build(mesh.view(), GetParam());
  expect_the_hosts_lists(host, rays, GetParam());
  const cuda::DeviceBvh bvh = cuda::DeviceBvh::upload(host, kStream);
  for (const std::uint32_t limit : {5u, 300u}) {
    EXPECT_EQ(list_hits(bvh, test::DeviceRays(rays).batch(), limit),
              lists_of(host.intersect_all(RayBatch(rays), {.limit = limit})));
  }
}

TEST_P(DeviceAllHits, OfNothingAreNone) {
  const test::HitLists of_no_rays = list_hits(bvh_, cuda::DeviceRayBatch{});
  EXPECT_EQ(of_no_rays, (test::HitLists{{0}, {}}));
  EXPECT_TRUE(count_hits(bvh_, cuda::DeviceRayBatch{}).empty());
  expect_the_hosts_lists(build(Mesh{}, GetParam()), rays_, "no mesh");
}

TEST_P(DeviceAllHits, OfRaysOnTheHostAreCountedInChunks) {
  std::vector<std::int64_t> expected(rays_.size());
  host_.count_hits(RayBatch(rays_), expected);
  for (const std::size_t bytes : {std::size_t{3000}, std::size_t{1} << 28}) {
    std::vector<std::int64_t> counts(rays_.size(), -1);
    bvh_.count_hits(RayBatch(rays_), test::kNoLimit, counts.data(), {RayOrder::given, bytes});
    EXPECT_EQ(counts, expected) << bytes;
  }
}

INSTANTIATE_TEST_SUITE_P(Layouts, DeviceAllHits, testing::ValuesIn(kRecipes));

// A chain is the deepest tree there is: its stack does not fit local memory.
TEST(DeviceAllHitsTest, OfDeepTreesAreTheHosts) {
  const test::OwnedMesh mesh = test::equal_centres(400);
  const std::vector<Ray> rays = test::rays_at(mesh.view(), 10, 3);
  Bvh host = test::chain_bvh2(mesh);
  expect_the_hosts_lists(host, rays, "whole faces, seed 3");
  ++host.report.references;  // as if one had been split
  expect_the_hosts_lists(host, rays, "split faces, seed 3");
}

TEST(DeviceAllHitsTest, AreThoseOfTheTreeAsItWasBuiltAndRebuiltThere) {
  const test::OwnedMesh mesh = test::triangle_soup(300, 8);
  const test::OwnedMesh moved = test::translated(mesh, {0.5f, 0, 0});
  const auto vertices = test::upload_all(std::span(mesh.vertices));
  const auto moved_vertices = test::upload_all(std::span(moved.vertices));
  const auto faces = test::upload_all(std::span(mesh.faces));
  const cuda::DeviceMesh view{vertices.data(), faces.data(), std::uint32_t(vertices.size()),
                              std::uint32_t(faces.size())};
  for (const char* recipe : {"lbvh > bvh2", "presplit(budget=50) > lbvh > cwbvh"}) {
    cuda::DeviceBvh bvh = cuda::DeviceBvh::build(view, parse_recipe(recipe),
                                                 {.validate = false, .updatable = true}, kStream);
    const std::vector<Ray> rays = test::rays_at(moved.view(), 10, 17);
    const test::DeviceRays device_rays(rays);
    EXPECT_EQ(list_hits(bvh, device_rays.batch()),
              lists_of(build(mesh.view(), recipe).intersect_all(RayBatch(rays))));
    bvh.rebuild(moved_vertices.data(), std::uint32_t(moved_vertices.size()), kStream);
    EXPECT_EQ(list_hits(bvh, device_rays.batch()),
              lists_of(build(moved.view(), recipe).intersect_all(RayBatch(rays))));
  }
}

}  // namespace
}  // namespace treelet
