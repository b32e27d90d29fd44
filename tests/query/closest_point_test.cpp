#include <treelet/query/closest_point.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <treelet/pipeline/build.h>
#include <treelet/pipeline/update.h>
#include <treelet/query/nearest_search.h>

#include "support/isas.h"
#include "support/mesh_params.h"
#include "support/mesh_points.h"
#include "support/meshes.h"
#include "support/random.h"
#include "support/threads.h"

namespace treelet {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr const char* kRecipes[] = {
    "lbvh > bvh2", "balanced", "lbvh > cwbvh", "sbvh > bvh2", "presplit > lbvh > bvh8",
    "sbvh > cwbvh"};

using test::points_around;

/// Smallest squared distance, of equal ones of the smallest face, of all triangles.
Nearest find_by_force(const Mesh& mesh, Vec3 point) {
  Nearest nearest;
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
    const Triangle triangle = mesh.triangle(face);
    if (classify(triangle) != TriangleKind::regular) continue;
    const double square = point_steps::view_from(point, triangle).squared_distance();
    if (square < nearest.squared_distance) nearest = {square, std::uint32_t(face), 0};
  }
  return nearest;
}

class ClosestPointOf : public testing::TestWithParam<test::NamedMesh> {};

TEST_P(ClosestPointOf, IsThatOfAllTrianglesInEveryLayout) {
  const Mesh mesh = GetParam().mesh.view();
  const std::vector<Vec3> points = points_around(GetParam().mesh, 60, 17);
  for (const char* recipe : kRecipes) {
    const Bvh bvh = build(mesh, recipe);
    for (const Vec3 point : points) {
      const ClosestPoint found = bvh.closest_point(point);
      const bool is_point = is_finite(point);
      const Nearest expected = is_point ? find_by_force(mesh, point) : Nearest{};
      ASSERT_EQ(found.face, std::int32_t(expected.face)) << recipe;
      ASSERT_EQ(found.distance, float(std::sqrt(expected.squared_distance))) << recipe;
      if (found.is_none()) continue;
      ASSERT_TRUE(found.u >= 0 && found.v >= 0 && found.u + found.v <= 1.000001f);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(HardMeshes, ClosestPointOf, testing::ValuesIn(test::hard_meshes()),
                         test::mesh_name);

TEST(ClosestPoint, AgreesOnAllInstructionSets) {
  const test::OwnedMesh mesh = test::triangle_soup(500, 5);
  const Bvh bvh = build(mesh.view(), "balanced");
  for (const Isa isa : test::runnable_isas()) {
    NearestSearcher<Bvh8> searcher(std::get<Bvh8>(bvh.layout), isa);
    for (const Vec3 point : points_around(mesh, 200, 6)) {
      const NearestQuery query{point};
      Nearest found;
      searcher.run({&query, 1}, &found);
      const Nearest expected = find_by_force(mesh.view(), point);
      ASSERT_EQ(found.face, expected.face);
      ASSERT_EQ(found.squared_distance, expected.squared_distance);
    }
  }
}

TEST(ClosestPoint, IsRightAtAnyScale) {
  for (const float scale : {1e-30f, 1e-12f, 1e12f, 1e30f}) {
    const test::OwnedMesh mesh = test::scaled(test::icosphere(2), scale);
    test::Random random(7);
    for (const char* recipe : kRecipes) {
      const Bvh bvh = build(mesh.view(), recipe);
      for (int i = 0; i < 50; ++i) {
        const Vec3 point = random.point(-3.0f * scale, 3.0f * scale);
        const Nearest expected = find_by_force(mesh.view(), point);
        const ClosestPoint found = bvh.closest_point(point);
        ASSERT_EQ(found.face, std::int32_t(expected.face)) << recipe << " at " << scale;
        ASSERT_GT(found.distance, 0.0f);
      }
    }
  }
}

TEST(ClosestPoint, IsOnTheTriangleFarFromTheOrigin) {
  const test::OwnedMesh mesh = test::translated(test::scaled(test::icosphere(3), 64), {1e6f, 0, 0});
  const Bvh bvh = build(mesh.view());
  test::Random random(8);
  for (int i = 0; i < 200; ++i) {
    const Vec3 point = random.point(-100, 100) + Vec3{1e6f, 0, 0};
    const ClosestPoint found = bvh.closest_point(point);
    const double dx = double(found.point.x) - point.x, dy = double(found.point.y) - point.y,
                 dz = double(found.point.z) - point.z;
    EXPECT_NEAR(std::sqrt(dx * dx + dy * dy + dz * dz), found.distance, 0.06);  // ulp of 1e6
  }
}

TEST(ClosestPoint, MeasuresSliversExactly) {
  // A needle of width 2^-20 and length 2^10; the point hangs over it at a height of 2^-10.
  const Triangle needle{{0, 0, 0}, {0x1p10f, 0, 0}, {0x1p10f, 0x1p-20f, 0}};
  const Vec3 point{0x1p9f, 0x1p-23f, 0x1p-10f};
  EXPECT_EQ(point_steps::view_from(point, needle).squared_distance(), 0x1p-20);
}

TEST(ClosestPoint, TiesGoToTheSmallerFace) {
  const test::OwnedMesh sphere = test::icosphere(2);
  const Bvh bvh = build(sphere.view(), "balanced");
  for (std::size_t i = 0; i < sphere.vertices.size(); ++i) {
    const ClosestPoint found = bvh.closest_point(sphere.vertices[i] * 2.0f);
    std::size_t face = 0;
    while (std::ranges::find(sphere.faces[face], i) == sphere.faces[face].end()) ++face;
    EXPECT_EQ(found.face, std::int32_t(face));
    EXPECT_EQ(found.point, sphere.vertices[i]);
  }
}

TEST(ClosestPoint, CountsPointsUpToTheLargestDistance) {
  test::OwnedMesh mesh;
  mesh.add({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  for (const char* recipe : kRecipes) {
    const Bvh bvh = build(mesh.view(), recipe);
    const Vec3 above{0.25f, 0.25f, 0.3f};
    EXPECT_EQ(bvh.closest_point(above, 0.3f).face, 0);
    EXPECT_TRUE(bvh.closest_point(above, std::nextafter(0.3f, 0.0f)).is_none());
    EXPECT_EQ(bvh.closest_point({0.25f, 0.25f, 0}, 0.0f).distance, 0.0f);
    EXPECT_TRUE(bvh.closest_point(above, -1.0f).is_none());
    EXPECT_TRUE(bvh.closest_point(above, std::nanf("")).is_none());
  }
}

TEST(ClosestPoint, HasNoneForBadPointsAndEmptyMeshes) {
  test::OwnedMesh mesh;
  mesh.add({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  const Bvh bvh = build(mesh.view());
  for (const float bad : {std::nanf(""), kInfinity, -kInfinity}) {
    const ClosestPoint found = bvh.closest_point({0, bad, 0});
    EXPECT_TRUE(std::isnan(found.point.x));
    EXPECT_EQ(found.distance, kInfinity);
    EXPECT_EQ(found.face, -1);
  }
  for (const char* recipe : kRecipes) {
    EXPECT_TRUE(build(test::empty_mesh().view(), recipe).closest_point({0, 0, 0}).is_none());
  }
}

TEST(ClosestPoint, SkipsTrianglesThatARefitHides) {
  test::OwnedMesh mesh = test::triangle_soup(100, 4);
  for (const char* recipe : {"lbvh > bvh2", "balanced", "lbvh > cwbvh"}) {
    UpdatableBvh tree(mesh.view(), recipe);
    std::vector<Vec3> moved = mesh.vertices;
    for (std::size_t face = 0; face < 100; face += 3) moved[mesh.faces[face][1]].x = std::nanf("");
    tree.refit(moved);
    const Mesh now{moved, mesh.faces};
    for (const Vec3 point : points_around(mesh, 50, 3)) {
      ASSERT_EQ(tree.bvh().closest_point(point).face, std::int32_t(find_by_force(now, point).face));
    }
  }
}

TEST(ClosestPoint, BatchesAnswerAsSinglePointsOnAnyNumberOfThreads) {
  const test::OwnedMesh mesh = test::triangle_soup(300, 9);
  const Bvh bvh = build(mesh.view());
  std::vector<Vec3> points = points_around(mesh, 2000, 10);
  points[5].x = std::nanf("");
  for (const unsigned threads : {1u, 3u}) {
    const test::ThreadCountScope scope(threads);
    std::vector<float> distance(points.size());
    std::vector<std::int32_t> face(points.size());
    bvh.closest_point(std::span<const Vec3>(points),
                      {.distance = distance.data(), .face = face.data()});
    for (std::size_t i = 0; i < points.size(); ++i) {
      const ClosestPoint single = bvh.closest_point(points[i]);
      ASSERT_EQ(distance[i], single.distance);
      ASSERT_EQ(face[i], single.face);
    }
  }
}

}  // namespace
}  // namespace treelet
