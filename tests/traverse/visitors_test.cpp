#include <treelet/traverse/visitors.h>

#include <gtest/gtest.h>

namespace treelet {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

Ray between(float t_min, float t_max) { return {{0, 0, 0}, {0, 0, 1}, t_min, t_max}; }

TEST(ClosestHit, MissesAtFirst) {
  const ClosestHit<> visitor(between(0, 9));
  EXPECT_EQ(visitor.hit, (Hit{kInfinity, -1, 0, 0}));
  EXPECT_FALSE(visitor.hit.is_hit());
  EXPECT_EQ(visitor.t_limit(), 9.0f);
}

TEST(ClosestHit, KeepsTheSmallestTAndNeverEnds) {
  ClosestHit<> visitor(between(0, 9));
  EXPECT_FALSE(visitor.visit(4, {5, 0.5f, 0.25f}));
  EXPECT_EQ(visitor.hit, (Hit{5, 4, 0.5f, 0.25f}));
  EXPECT_EQ(visitor.t_limit(), 5.0f);
  EXPECT_FALSE(visitor.visit(7, {3, 0.1f, 0.2f}));
  EXPECT_FALSE(visitor.visit(1, {6, 0, 0}));
  EXPECT_EQ(visitor.hit, (Hit{3, 7, 0.1f, 0.2f}));
  EXPECT_EQ(visitor.t_limit(), 3.0f);
}

TEST(ClosestHit, OfEqualTTheSmallerFaceWinsInAnyOrder) {
  for (const bool smaller_first : {false, true}) {
    ClosestHit<> visitor(between(0, 9));
    visitor.visit(smaller_first ? 2 : 8, {5, 0, 0});
    visitor.visit(smaller_first ? 8 : 2, {5, 0, 0});
    EXPECT_EQ(visitor.hit.face, 2);
  }
}

TEST(ClosestHit, FaceZeroAtAnEqualTWins) {
  ClosestHit<> visitor(between(0, 9));
  visitor.visit(1, {5, 0, 0});
  visitor.visit(0, {5, 0, 0});
  EXPECT_EQ(visitor.hit.face, 0);
}

TEST(ClosestHit, IntervalIsClosed) {
  const auto accepts = [](float t_min, float t_max, float t) {
    ClosestHit<> visitor(between(t_min, t_max));
    visitor.visit(0, {t, 0, 0});
    return visitor.hit.is_hit();
  };
  EXPECT_TRUE(accepts(2, 4, 2));
  EXPECT_TRUE(accepts(2, 4, 4));
  EXPECT_TRUE(accepts(3, 3, 3));
  EXPECT_FALSE(accepts(2, 4, std::nextafter(2.0f, 0.0f)));
  EXPECT_FALSE(accepts(2, 4, std::nextafter(4.0f, 9.0f)));
  EXPECT_TRUE(accepts(-5, -1, -3));
  EXPECT_FALSE(accepts(0, kInfinity, kInfinity));
  EXPECT_FALSE(accepts(0, kInfinity, kNan));
}

TEST(ClosestHit, CountsItsWork) {
  ClosestHit<Counting> visitor(between(0, 9));
  visitor.count_node();
  visitor.count_node();
  visitor.count_triangles(1);
  EXPECT_EQ(visitor.work.nodes, 2u);
  EXPECT_EQ(visitor.work.triangles, 1u);
}

TEST(AnyHit, EndsAtTheFirstHitInTheInterval) {
  AnyHit visitor(between(2, 4));
  EXPECT_EQ(visitor.t_limit(), 4.0f);
  EXPECT_FALSE(visitor.visit(0, {1, 0, 0}));
  EXPECT_FALSE(visitor.visit(0, {5, 0, 0}));
  EXPECT_FALSE(visitor.visit(0, {kNan, 0, 0}));
  EXPECT_FALSE(visitor.found);
  EXPECT_TRUE(visitor.visit(0, {2, 0, 0}));
  EXPECT_TRUE(visitor.found);
  EXPECT_TRUE(AnyHit(between(2, 4)).visit(0, {4, 0, 0}));
  EXPECT_FALSE(AnyHit(between(0, kInfinity)).visit(0, {kInfinity, 0, 0}));
}

}  // namespace
}  // namespace treelet
