#include <treelet/query/winding_number.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <treelet/pipeline/build.h>
#include <treelet/pipeline/update.h>

#include "support/meshes.h"
#include "support/random.h"
#include "support/threads.h"

namespace treelet {
namespace {

constexpr float kExact = std::numeric_limits<float>::infinity();
constexpr const char* kRecipes[] = {"lbvh > bvh2", "balanced", "lbvh > cwbvh",
                                    "presplit > lbvh > bvh8", "sbvh > bvh2"};

std::vector<float> wind(const Bvh& bvh, const std::vector<Vec3>& points, float accuracy) {
  std::vector<float> answers(points.size());
  bvh.winding_number(std::span<const Vec3>(points), accuracy, answers);
  return answers;
}

/// One arctangent a triangle, by the formula as published.
double wind_by_force(const Mesh& mesh, Vec3 eye) {
  using point_steps::DoubleVector;
  double sum = 0.0;
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
    const Triangle t = mesh.triangle(face);
    if (classify(t) != TriangleKind::regular) continue;
    const auto seen = [&](Vec3 p) { return point_steps::widen(p) - point_steps::widen(eye); };
    const DoubleVector a = seen(t.p0), b = seen(t.p1), c = seen(t.p2);
    const double la = std::sqrt(dot(a, a)), lb = std::sqrt(dot(b, b)), lc = std::sqrt(dot(c, c));
    sum += 2.0 * std::atan2(dot(a, cross(b, c)),
                            la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
  }
  return sum / (4.0 * std::numbers::pi);
}

std::vector<Vec3> points_in_cube(std::size_t count, float size, std::uint64_t seed) {
  test::Random random(seed);
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < count; ++i) points.push_back(random.point(-size, size));
  return points;
}

TEST(WindingNumber, IsAnIntegerForClosedMeshes) {
  for (const float scale : {1e-30f, 1.0f, 1e30f}) {
    const test::OwnedMesh sphere = test::scaled(test::icosphere(3), scale);
    const std::vector<Vec3> points = points_in_cube(200, 1.5f * scale, 1);
    for (const char* recipe : kRecipes) {
      const std::vector<float> found = wind(build(sphere.view(), recipe), points, kExact);
      for (std::size_t i = 0; i < points.size(); ++i) {
        const double r = std::hypot(points[i].x / scale, points[i].y / scale, points[i].z / scale);
        if (r > 0.95 && r < 1.0) continue;  // the sphere is made of chords
        ASSERT_NEAR(found[i], r < 1.0 ? 1.0 : 0.0, 1e-5) << recipe << " at " << scale;
      }
    }
  }
}

TEST(WindingNumber, IsThatOfAllTrianglesForOpenMeshes) {
  const std::vector<Vec3> points = points_in_cube(100, 2.0f, 2);
  for (const test::NamedMesh& hard : test::hard_meshes()) {
    if (hard.name.find("giant") != std::string::npos) continue;
    for (const char* recipe : kRecipes) {
      const std::vector<float> found = wind(build(hard.mesh.view(), recipe), points, kExact);
      for (std::size_t i = 0; i < points.size(); ++i) {
        ASSERT_NEAR(found[i], wind_by_force(hard.mesh.view(), points[i]), 1e-5)
            << hard.name << " " << recipe;
      }
    }
  }
}

TEST(WindingNumber, ApproximatesFarParts) {
  const test::OwnedMesh soup = test::triangle_soup(1000, 3), sphere = test::icosphere(4);
  for (const test::OwnedMesh* mesh : {&soup, &sphere}) {
    const std::vector<Vec3> points = points_in_cube(500, 1.5f, 4);
    for (const char* recipe : kRecipes) {
      const Bvh bvh = build(mesh->view(), recipe);
      const std::vector<float> exact = wind(bvh, points, kExact);
      const std::vector<float> near = wind(bvh, points, 2.0f), better = wind(bvh, points, 6.0f);
      double error = 0.0, better_error = 0.0;
      for (std::size_t i = 0; i < points.size(); ++i) {
        error = std::max(error, std::fabs(double(near[i]) - exact[i]));
        better_error = std::max(better_error, std::fabs(double(better[i]) - exact[i]));
      }
      EXPECT_LT(error, 0.03) << recipe;
      EXPECT_LT(better_error, 0.003) << recipe;
      EXPECT_GT(error, 0.0) << recipe;  // else nothing was approximated
    }
  }
}

TEST(WindingNumber, IsTheSameOnAnyNumberOfThreadsAndForgottenByARefit) {
  const test::OwnedMesh sphere = test::icosphere(3);
  const std::vector<Vec3> points = points_in_cube(1000, 1.5f, 5);
  UpdatableBvh tree(sphere.view());
  const std::vector<float> before = wind(tree.bvh(), points, 2.0f);
  {
    const test::ThreadCountScope scope(3);
    EXPECT_EQ(wind(tree.bvh(), points, 2.0f), before);
  }
  tree.refit(test::translated(sphere, {10, 0, 0}).vertices);
  EXPECT_NEAR(wind(tree.bvh(), {{10, 0, 0}}, 2.0f)[0], 1.0f, 0.1);
  EXPECT_NEAR(wind(tree.bvh(), {{0, 0, 0}}, 2.0f)[0], 0.0f, 0.1);
}

TEST(WindingNumber, HasAnswersForEmptyMeshesAndBadPoints) {
  EXPECT_EQ(wind(build(test::empty_mesh().view()), {{0, 0, 0}}, 2.0f)[0], 0.0f);
  test::OwnedMesh triangle;
  triangle.add({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  const Bvh bvh = build(triangle.view());
  EXPECT_TRUE(std::isnan(wind(bvh, {{0, std::nanf(""), 0}}, 2.0f)[0]));
  EXPECT_EQ(wind(bvh, {{0.25f, 0.25f, 0}}, 2.0f)[0], 0.0f);  // on the triangle: seen edge-on
}

}  // namespace
}  // namespace treelet
