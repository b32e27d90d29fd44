#include <treelet/query/overlap.h>

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include <treelet/pipeline/build.h>
#include <treelet/query/closest_point.h>
#include <treelet/query/point_triangle_steps.h>
#include <treelet/query/triangle_box.h>

#include "support/big_integer.h"
#include "support/meshes.h"
#include "support/random.h"
#include "support/threads.h"

namespace treelet {
namespace {

constexpr const char* kRecipes[] = {"lbvh > bvh2", "balanced", "lbvh > cwbvh", "sbvh > bvh8"};

using test::BigInteger;
using Exact = std::array<BigInteger, 3>;

Exact exact(Vec3 p) {
  const auto integer = [](float x) { return BigInteger::from_scaled(x, 149); };
  return {integer(p.x), integer(p.y), integer(p.z)};
}
Exact minus(const Exact& a, const Exact& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Exact cross_product(const Exact& a, const Exact& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
bool is_less(const BigInteger& a, const BigInteger& b) { return (a - b).sign() < 0; }

/// Whether the projections on the axis are apart.
bool is_separating(const Exact& axis, const Exact* triangle, const Exact* corners) {
  const auto project = [&](const Exact& p) {
    return axis[0] * p[0] + axis[1] * p[1] + axis[2] * p[2];
  };
  const auto range = [&](const Exact* points, int count) {
    std::array<BigInteger, 2> found{project(points[0]), project(points[0])};
    for (int i = 1; i < count; ++i) {
      const BigInteger x = project(points[i]);
      if (is_less(x, found[0])) found[0] = x;
      if (is_less(found[1], x)) found[1] = x;
    }
    return found;
  };
  const auto a = range(triangle, 3), b = range(corners, 8);
  return is_less(a[1], b[0]) || is_less(b[1], a[0]);
}

/// All thirteen axes, in integers.
bool overlaps_exactly(const Triangle& t, const Aabb& box) {
  const Exact p[3] = {exact(t.p0), exact(t.p1), exact(t.p2)};
  Exact corners[8];
  for (int i = 0; i < 8; ++i) {
    corners[i] = exact({i & 1 ? box.upper.x : box.lower.x, i & 2 ? box.upper.y : box.lower.y,
                        i & 4 ? box.upper.z : box.lower.z});
  }
  const Exact sides[3] = {exact({1, 0, 0}), exact({0, 1, 0}), exact({0, 0, 1})};
  const Exact edges[3] = {minus(p[1], p[0]), minus(p[2], p[1]), minus(p[0], p[2])};
  if (is_separating(cross_product(edges[0], edges[1]), p, corners)) return false;
  for (const Exact& side : sides) {
    if (is_separating(side, p, corners)) return false;
    for (const Exact& edge : edges) {
      if (is_separating(cross_product(side, edge), p, corners)) return false;
    }
  }
  return true;
}

/// Few different coordinates, so that much touches; some moved by the last bit.
Vec3 coarse_point(test::Random& random) {
  const auto coordinate = [&] {
    const float x = float(random.below(5)) * 0.3f - 0.6f;
    return random.below(3) == 0 ? std::nextafter(x, 2.0f) : x;
  };
  const float x = coordinate(), y = coordinate(), z = coordinate();
  return {x, y, z};
}

TEST(TriangleBox, AgreesWithIntegers) {
  test::Random random(11);
  int touching = 0;
  for (int i = 0; i < 20000; ++i) {
    const Triangle t{coarse_point(random), coarse_point(random), coarse_point(random)};
    const Vec3 p = coarse_point(random), q = coarse_point(random);
    const Aabb box{min(p, q), max(p, q)};
    const bool expected = overlaps_exactly(t, box);
    touching += expected;
    ASSERT_EQ(overlaps(t, box), expected) << "case " << i << " of seed 11";
  }
  EXPECT_GT(touching, 2000);
  EXPECT_LT(touching, 18000);
}

TEST(TriangleBox, CountsTouching) {
  const Triangle t{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const float above = std::nextafter(0.5f, 1.0f);
  EXPECT_TRUE(overlaps(t, {{0.5f, 0.5f, 0}, {2, 2, 1}}));  // a corner on the longest edge
  EXPECT_FALSE(overlaps(t, {{0.5f, above, 0}, {2, 2, 1}}));
  EXPECT_TRUE(overlaps(t, {{0, 0, -1}, {1, 1, 0}}));
  EXPECT_FALSE(overlaps(t, {{0, 0, -1}, {1, 1, -1e-45f}}));
}

std::vector<std::int32_t> row(const Overlaps& overlaps, std::size_t i) {
  return {overlaps.face.begin() + overlaps.offsets[i],
          overlaps.face.begin() + overlaps.offsets[i + 1]};
}

TEST(OverlapBoxes, ListsTheFacesThatAllTrianglesGive) {
  test::Random random(12);
  for (const test::NamedMesh& hard : test::hard_meshes()) {
    std::vector<Vec3> lower, upper;
    for (int i = 0; i < 80; ++i) {
      const Vec3 p = random.point(-1, 1), q = p + random.point(0, 0.5f);
      lower.push_back(p);
      upper.push_back(q);
    }
    for (const char* recipe : kRecipes) {
      const Bvh bvh = build(hard.mesh.view(), recipe);
      const Overlaps found = bvh.overlap_boxes(
          {lower.size(), {lower.data(), sizeof(Vec3)}, {upper.data(), sizeof(Vec3)}});
      for (std::size_t i = 0; i < lower.size(); ++i) {
        std::vector<std::int32_t> expected;
        for (std::size_t face = 0; face < hard.mesh.faces.size(); ++face) {
          const Triangle t = hard.mesh.view().triangle(face);
          if (classify(t) != TriangleKind::regular || !overlaps(t, {lower[i], upper[i]})) continue;
          expected.push_back(std::int32_t(face));
        }
        ASSERT_EQ(row(found, i), expected) << hard.name << " " << recipe;
      }
    }
  }
}

TEST(OverlapBoxes, TakesInfiniteBoxesAndRefusesBadOnes) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const test::OwnedMesh mesh = test::icosphere(2);
  const Bvh bvh = build(mesh.view());
  const Vec3 all_lower{-kInfinity, -kInfinity, -kInfinity},
      all_upper{kInfinity, kInfinity, kInfinity};
  const Vec3 lower[4] = {all_lower, all_upper, {std::nanf(""), -9, -9}, {5, 5, 5}};
  const Vec3 upper[4] = {all_upper, all_lower, {9, 9, 9}, {6, 6, 6}};
  const Overlaps found = bvh.overlap_boxes({4, {lower, sizeof(Vec3)}, {upper, sizeof(Vec3)}});
  EXPECT_EQ(row(found, 0).size(), mesh.faces.size());
  for (std::size_t i = 1; i < 4; ++i) EXPECT_TRUE(row(found, i).empty()) << i;
  EXPECT_EQ(
      build(test::empty_mesh().view()).overlap_boxes({4, {lower, 12}, {upper, 12}}).face.size(),
      0u);
}

TEST(OverlapSpheres, AgreesWithDistances) {
  test::Random random(13);
  const test::OwnedMesh mesh = test::triangle_soup(300, 14);
  for (const char* recipe : kRecipes) {
    const Bvh bvh = build(mesh.view(), recipe);
    for (const unsigned threads : {1u, 2u}) {
      const test::ThreadCountScope scope(threads);
      std::vector<Vec3> centers;
      std::vector<float> radii;
      for (int i = 0; i < 200; ++i) {
        centers.push_back(random.point(-0.5f, 1.5f));
        const float nearest = bvh.closest_point(centers.back()).distance;
        radii.push_back(i % 3 == 0   ? nearest
                        : i % 3 == 1 ? std::nextafter(nearest, 0.0f)
                                     : random.uniform(0, 0.5f));
      }
      PointBatch spheres{std::span<const Vec3>(centers)};
      spheres.radii = {radii.data(), sizeof(float)};
      const Overlaps found = bvh.overlap_spheres(spheres);
      for (std::size_t i = 0; i < centers.size(); ++i) {
        std::vector<std::int32_t> expected;
        for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
          const auto view = point_steps::view_from(centers[i], mesh.view().triangle(face));
          if (float(std::sqrt(view.squared_distance())) > radii[i]) continue;
          expected.push_back(std::int32_t(face));
        }
        ASSERT_EQ(row(found, i), expected) << recipe;
        EXPECT_EQ(expected.empty(), i % 3 == 1 || (i % 3 == 2 && expected.empty()));
      }
    }
  }
}

}  // namespace
}  // namespace treelet
