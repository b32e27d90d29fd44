#include <treelet/query/device_closest_point.h>
#include <treelet/query/device_contains.h>

#include <gtest/gtest.h>

#include <treelet/pipeline/build.h>
#include <treelet/pipeline/device_bvh.h>

#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "cuda/deep_trees.h"
#include "cuda/device_input.h"
#include "cuda/schedules.h"
#include "support/closed_meshes.h"
#include "support/mesh_params.h"
#include "support/mesh_points.h"
#include "support/meshes.h"
#include "support/random.h"

// Closest points, inside and outside.

namespace treelet {
namespace {

using test::kStream;

/// All layouts, with whole faces and with split ones.
constexpr const char* kRecipes[] = {"lbvh > bvh2",
                                    "lbvh > bvh8",
                                    "lbvh > cwbvh",
                                    "presplit(budget=80) > lbvh > bvh2(leaf=1)",
                                    "sbvh(budget=80) > bvh8",
                                    "presplit(budget=80) > lbvh > cwbvh"};

/// All that is asked of points; NaN are compared by their bits.
struct PointAnswers {
  std::vector<ClosestPoint> closest;
  std::vector<bool> inside;
  std::vector<float> signed_distance;

  bool closest_equal(const PointAnswers& other, std::size_t i) const {
    return std::memcmp(&closest[i], &other.closest[i], sizeof(ClosestPoint)) == 0;
  }
};

PointAnswers ask_host(const Bvh& bvh, const std::vector<Vec3>& points, float radius) {
  PointAnswers answers;
  for (const Vec3 point : points) answers.closest.push_back(bvh.closest_point(point, radius));
  const auto inside = std::make_unique<bool[]>(points.size());
  answers.signed_distance.resize(points.size());
  bvh.contains(std::span<const Vec3>(points), std::span(inside.get(), points.size()));
  bvh.signed_distance(std::span<const Vec3>(points), answers.signed_distance);
  answers.inside.assign(inside.get(), inside.get() + points.size());
  return answers;
}

PointAnswers ask_device(const cuda::DeviceBvh& bvh, const std::vector<Vec3>& points, float radius) {
  const std::size_t size = points.size();
  const auto device_points = test::upload_all(std::span(points));
  cuda::DeviceArray<Vec3> point(size, kStream);
  cuda::DeviceArray<float> distance(size, kStream), u(size, kStream), v(size, kStream),
      signed_distance(size, kStream);
  cuda::DeviceArray<std::int32_t> face(size, kStream);
  cuda::DeviceArray<bool> inside(size, kStream);
  cuda::DevicePointBatch batch;
  batch.size = size;
  batch.points = {device_points.data(), sizeof(Vec3)};
  bvh.contains(batch, inside.data(), kStream);
  bvh.signed_distance(batch, signed_distance.data(), kStream);
  batch.all_radii = radius;
  bvh.closest_point(batch, {point.data(), distance.data(), face.data(), u.data(), v.data()},
                    kStream);
  const auto p = cuda::download(point);
  const auto d = cuda::download(distance), us = cuda::download(u), vs = cuda::download(v);
  const auto f = cuda::download(face);
  PointAnswers answers;
  for (std::size_t i = 0; i < size; ++i) {
    answers.closest.push_back({p[i], d[i], f[i], us[i], vs[i]});
  }
  const auto in = cuda::download(inside);
  const auto s = cuda::download(signed_distance);
  answers.inside.assign(in.begin(), in.end());
  answers.signed_distance.assign(s.begin(), s.end());
  return answers;
}

void expect_the_hosts_answers(const Bvh& host, const std::vector<Vec3>& points,
                              const std::string& what,
                              float radius = std::numeric_limits<float>::infinity()) {
  const cuda::DeviceBvh bvh = cuda::DeviceBvh::upload(host, kStream);
  const PointAnswers expected = ask_host(host, points, radius);
  const PointAnswers answers = ask_device(bvh, points, radius);
  for (std::size_t i = 0; i < points.size(); ++i) {
    ASSERT_TRUE(answers.closest_equal(expected, i))
        << what << ", point " << i << ": face " << answers.closest[i].face << " at "
        << answers.closest[i].distance << ", not face " << expected.closest[i].face << " at "
        << expected.closest[i].distance;
  }
  EXPECT_EQ(answers.inside, expected.inside) << what;
  EXPECT_EQ(answers.signed_distance, expected.signed_distance) << what;
}

class DevicePointsOf : public testing::TestWithParam<test::NamedMesh> {};

TEST_P(DevicePointsOf, AreAnsweredLikeTheHostInEveryLayout) {
  const std::vector<Vec3> points = test::points_around(GetParam().mesh, 40, 17);
  std::uint64_t schedule = 0;
  for (const char* recipe : kRecipes) {
    const Bvh host = build(GetParam().mesh.view(), recipe);
    test::with_schedule(schedule++ % 4, [&] {
      expect_the_hosts_answers(host, points, std::string(recipe) + ", seed 17");
    });
    if (HasFatalFailure()) return;
  }
}

INSTANTIATE_TEST_SUITE_P(HardMeshes, DevicePointsOf, testing::ValuesIn(test::hard_meshes()),
                         test::mesh_name);

class DevicePoints : public testing::TestWithParam<const char*> {};

TEST_P(DevicePoints, OfClosedMeshesAreAnsweredLikeTheHost) {
  for (const auto& [name, mesh] : test::closed_meshes()) {
    const std::vector<Vec3> points = test::points_around(mesh, 30, 23);
    expect_the_hosts_answers(build(mesh.view(), GetParam()), points, name + ", seed 23");
    if (HasFatalFailure()) return;
  }
}

TEST_P(DevicePoints, CountUpToTheLargestDistance) {
  const test::OwnedMesh mesh = test::triangle_soup(200, 5);
  const Bvh host = build(mesh.view(), GetParam());
  const std::vector<Vec3> points = test::points_around(mesh, 60, 6);
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  for (const float radius : {0.0f, 0.05f, 0.3f, 1e30f, -1.0f, kNaN}) {
    expect_the_hosts_answers(host, points, "seeds 5, 6", radius);
    if (HasFatalFailure()) return;
  }
}

TEST_P(DevicePoints, AreAnsweredAtAnyScale) {
  for (const float scale : {1e-44f, 1e-30f, 1e-12f, 1e12f, 1e30f, 1e37f}) {
    const test::OwnedMesh mesh = test::scaled(test::icosphere(1), scale);
    test::Random random(7);
    std::vector<Vec3> points;
    for (int i = 0; i < 40; ++i) points.push_back(random.point(-3.0f * scale, 3.0f * scale));
    points.push_back({1e38f, -1e38f, 3.0f});
    expect_the_hosts_answers(build(mesh.view(), GetParam()), points, std::to_string(scale));
    if (HasFatalFailure()) return;
  }
}

TEST_P(DevicePoints, ThatAreBadOrOfAnEmptyMeshHaveNoAnswer) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const std::vector<Vec3> points{{0, std::numeric_limits<float>::quiet_NaN(), 0},
                                 {kInfinity, 0, 0},
                                 {0, 0, -kInfinity},
                                 {0.5f, 0.5f, 0.5f}};
  expect_the_hosts_answers(build(test::cube().view(), GetParam()), points, "bad points");
  expect_the_hosts_answers(build(Mesh{}, GetParam()), points, "no mesh");
  expect_the_hosts_answers(build(test::cube().view(), GetParam()), {}, "no points");
}

INSTANTIATE_TEST_SUITE_P(Layouts, DevicePoints, testing::ValuesIn(kRecipes));

TEST(DevicePointsTest, AreAnsweredLikeTheHostInDeepTrees) {
  const test::OwnedMesh mesh = test::triangle_soup(400, 4);
  Bvh host = test::chain_bvh2(mesh);
  const std::vector<Vec3> points = test::points_around(mesh, 20, 5);
  expect_the_hosts_answers(host, points, "whole faces, seeds 4, 5");
  ++host.report.references;  // as if one had been split
  expect_the_hosts_answers(host, points, "split faces, seeds 4, 5");
}

TEST(DevicePointsTest, SkipTrianglesThatARefitHides) {
  const test::OwnedMesh mesh = test::triangle_soup(100, 4);
  test::OwnedMesh moved = mesh;
  for (std::size_t face = 0; face < 100; face += 3) {
    moved.vertices[moved.faces[face][1]].x = std::numeric_limits<float>::quiet_NaN();
  }
  const auto vertices = test::upload_all(std::span(mesh.vertices));
  const auto moved_vertices = test::upload_all(std::span<const Vec3>(moved.vertices));
  const auto faces = test::upload_all(std::span(mesh.faces));
  const cuda::DeviceMesh view{vertices.data(), faces.data(), std::uint32_t(vertices.size()),
                              std::uint32_t(faces.size())};
  for (const char* recipe : {"lbvh > bvh2", "lbvh > bvh8", "lbvh > cwbvh"}) {
    cuda::DeviceBvh bvh = cuda::DeviceBvh::build(view, parse_recipe(recipe),
                                                 {.validate = false, .updatable = true}, kStream);
    bvh.refit(moved_vertices.data(), std::uint32_t(moved_vertices.size()), kStream);
    const std::vector<Vec3> points = test::points_around(mesh, 50, 3);
    const Bvh host = build(moved.view(), recipe);
    const PointAnswers answers = ask_device(bvh, points, 1e30f);
    for (std::size_t i = 0; i < points.size(); ++i) {
      ASSERT_EQ(answers.closest[i].face, host.closest_point(points[i]).face) << recipe;
    }
  }
}

}  // namespace
}  // namespace treelet
