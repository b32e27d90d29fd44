#include <treelet/layout/cover.h>

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "support/random.h"

namespace treelet {
namespace {

constexpr Triangle kTriangle{{0, 0, 0}, {4, 0, 2}, {0, 4, 0}};

/// The cells of a grid over the triangle's box.
std::vector<Aabb> grid_boxes(int cells) {
  std::vector<Aabb> boxes;
  for (int x = 0; x < cells; ++x) {
    for (int y = 0; y < cells; ++y) {
      const float w = 4.0f / float(cells);
      boxes.push_back({{w * float(x), w * float(y), 0}, {w * float(x + 1), w * float(y + 1), 2}});
    }
  }
  return boxes;
}

TEST(Cover, OfItsOwnBox) {
  const std::vector<Aabb> boxes{bounds(kTriangle)};
  EXPECT_EQ(uncovered_area(kTriangle, boxes), 0.0);
  EXPECT_TRUE(covers(boxes, kTriangle));
}

TEST(Cover, OfNothingIsTheWholeArea) {
  EXPECT_DOUBLE_EQ(uncovered_area(kTriangle, {}), 4.0 * std::sqrt(5.0));
  EXPECT_FALSE(covers({}, kTriangle));
}

TEST(Cover, OfAGridNeedsEachCellThatTheTriangleMeets) {
  std::vector<Aabb> boxes = grid_boxes(8);
  EXPECT_TRUE(covers(boxes, kTriangle));
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    std::vector<Aabb> fewer = boxes;
    fewer.erase(fewer.begin() + std::ptrdiff_t(i));
    const bool is_met = i / 8 + i % 8 < 8;
    EXPECT_EQ(covers(fewer, kTriangle), !is_met) << "cell " << i;
  }
}

TEST(Cover, MissesNoGapOfAnUlp) {
  for (const float x : {0.3f, 1.0f, 2.5f, 3.9f}) {
    const Aabb left{{0, 0, 0}, {x, 4, 2}};
    EXPECT_TRUE(covers(std::vector<Aabb>{left, {{x, 0, 0}, {4, 4, 2}}}, kTriangle));
    const float gap = std::nextafter(x, 4.0f);
    EXPECT_FALSE(covers(std::vector<Aabb>{left, {{gap, 0, 0}, {4, 4, 2}}}, kTriangle)) << x;
  }
}

TEST(Cover, TakesOverlappingBoxesInAnyOrder) {
  test::Random random(1);
  for (int i = 0; i < 50; ++i) {
    std::vector<Aabb> boxes = grid_boxes(6);
    for (Aabb& box : boxes) {
      box.lower = box.lower - random.point(0.0f, 0.5f);
      box.upper = box.upper + random.point(0.0f, 0.5f);
    }
    for (std::size_t j = boxes.size(); j > 1; --j) std::swap(boxes[j - 1], boxes[random.below(j)]);
    EXPECT_TRUE(covers(boxes, kTriangle)) << "seed 1, case " << i;
  }
}

TEST(Cover, OfAFlatTriangle) {
  const Triangle flat{{0, 0, 1}, {1, 0, 1}, {0, 1, 1}};
  const std::vector<Aabb> both{{{0, 0, 1}, {0.5f, 1, 1}}, {{0.5f, 0, 1}, {1, 0.5f, 1}}};
  EXPECT_TRUE(covers(both, flat));
  EXPECT_FALSE(covers(std::vector<Aabb>{both[0]}, flat));
  EXPECT_NEAR(uncovered_area(flat, std::vector<Aabb>{both[0]}), 0.125, 1e-12);
}

TEST(Cover, AtAnyScale) {
  for (const float scale : {1e30f, 1e-30f}) {
    const Triangle t{kTriangle.p0 * scale, kTriangle.p1 * scale, kTriangle.p2 * scale};
    std::vector<Aabb> boxes = grid_boxes(4);
    for (Aabb& box : boxes) box = {box.lower * scale, box.upper * scale};
    EXPECT_TRUE(covers(boxes, t));
    boxes.pop_back();
    boxes.erase(boxes.begin());
    EXPECT_FALSE(covers(boxes, t));
  }
}

}  // namespace
}  // namespace treelet
