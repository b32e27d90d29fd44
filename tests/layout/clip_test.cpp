#include <treelet/layout/clip.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "support/random.h"

namespace treelet {
namespace {

double clipped_area(const Triangle& triangle, const Aabb& box) {
  ClippedTriangle polygon(triangle);
  polygon.clip(box);
  return polygon.area();
}

const Triangle kRight{{0, 0, 0}, {2, 0, 0}, {0, 2, 0}};

TEST(Clip, AreaOfAWholeTriangle) {
  EXPECT_DOUBLE_EQ(ClippedTriangle(kRight).area(), 2.0);
  EXPECT_DOUBLE_EQ(ClippedTriangle({{0, 0, 0}, {0, 3, 0}, {0, 0, 4}}).area(), 6.0);
  EXPECT_DOUBLE_EQ(ClippedTriangle({{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}).area(), 0.0);
}

TEST(Clip, ATriangleInsideIsKeptAsItIs) {
  ClippedTriangle polygon(kRight);
  polygon.clip({{0, 0, 0}, {2, 2, 0}});
  EXPECT_EQ(polygon.size, 3);
  EXPECT_DOUBLE_EQ(polygon.area(), 2.0);
}

TEST(Clip, NothingIsLeftOutside) {
  ClippedTriangle polygon(kRight);
  polygon.clip({{0, 0, 1}, {2, 2, 2}});
  EXPECT_EQ(polygon.size, 0);
  EXPECT_EQ(polygon.area(), 0.0);
  EXPECT_EQ(clipped_area(kRight, {{1.5f, 1.5f, -1}, {2, 2, 1}}), 0.0);  // in its box, not in it
}

TEST(Clip, PiecesByHand) {
  EXPECT_DOUBLE_EQ(clipped_area(kRight, {{0, 0, -1}, {1, 1, 1}}), 1.0);
  EXPECT_DOUBLE_EQ(clipped_area(kRight, {{1, 0, -1}, {5, 5, 1}}), 0.5);
  EXPECT_DOUBLE_EQ(clipped_area(kRight, {{-5, 0.5f, -1}, {5, 1.5f, 1}}), 1.0);
}

TEST(Clip, ACubeCutsAHexagonFromItsDiagonalPlane) {
  // x + y + z = 1.5 cuts the unit cube in a regular hexagon of side sqrt(1/2).
  ClippedTriangle polygon({{4.5f, -1.5f, -1.5f}, {-1.5f, 4.5f, -1.5f}, {-1.5f, -1.5f, 4.5f}});
  polygon.clip({{0, 0, 0}, {1, 1, 1}});
  EXPECT_EQ(polygon.size, 6);
  EXPECT_NEAR(polygon.area(), 1.5 * std::sqrt(3.0) * 0.5, 1e-12);
}

TEST(Clip, PiecesOfAGridSumToTheTriangle) {
  constexpr int kCells = 5;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    test::Random random(seed);
    // No vertex on a plane between cells, where a piece in that plane would count twice.
    const Triangle triangle{random.point(0.01f, 0.99f), random.point(0.01f, 0.99f),
                            random.point(0.01f, 0.99f)};
    double sum = 0.0;
    for (int cell = 0; cell < kCells * kCells * kCells; ++cell) {
      const int index[3] = {cell % kCells, cell / kCells % kCells, cell / kCells / kCells};
      const auto plane = [&](int axis, int step) { return float(index[axis] + step) / kCells; };
      sum += clipped_area(triangle, {{plane(0, 0), plane(1, 0), plane(2, 0)},
                                     {plane(0, 1), plane(1, 1), plane(2, 1)}});
    }
    const double area = ClippedTriangle(triangle).area();
    EXPECT_NEAR(sum, area, 1e-12 * std::max(1.0, area));
  }
}

TEST(Clip, WhatIsLeftLiesInTheBox) {
  for (std::uint64_t seed = 1; seed <= 2000; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    test::Random random(seed);
    const Vec3 sliver = random.point(-1.0f, 1.0f);
    const Triangle triangle{random.point(-1.0f, 1.0f), sliver,
                            sliver + random.point(-1e-6f, 1e-6f) * (seed % 2 ? 1.0f : 1e6f)};
    const Vec3 lower = random.point(-1.0f, 0.5f);
    const Aabb box{lower, lower + random.point(0.0f, 0.5f)};
    ClippedTriangle polygon(triangle);
    polygon.clip(box);
    ASSERT_LE(polygon.size, 9);
    for (int i = 0; i < polygon.size; ++i) {
      for (int axis = 0; axis < 3; ++axis) {
        EXPECT_GE(polygon.vertex[std::size_t(i)][std::size_t(axis)], box.lower[axis] - 1e-12);
        EXPECT_LE(polygon.vertex[std::size_t(i)][std::size_t(axis)], box.upper[axis] + 1e-12);
      }
    }
    EXPECT_LE(polygon.area(), ClippedTriangle(triangle).area() * (1.0 + 1e-12));
  }
}

}  // namespace
}  // namespace treelet
