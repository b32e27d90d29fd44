#include <treelet/tree/sah.h>

#include <gtest/gtest.h>

namespace treelet {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

TEST(SahModel, HasTheConstantsOfThePaper) {
  const SahModel sah;
  EXPECT_EQ(sah.traversal_cost, 1.2f);
  EXPECT_EQ(sah.intersection_cost, 1.0f);
  EXPECT_EQ(sah.leaf_limit, 8u);
}

TEST(SahModel, CountsAreaTimesWork) {
  const SahModel sah{2.0f, 3.0f, 4};
  EXPECT_EQ(sah.internal_cost(10.0f, 7.0f), 27.0f);
  EXPECT_EQ(sah.leaf_cost(10.0f, 1), 30.0f);
  EXPECT_EQ(sah.leaf_cost(10.0f, 4), 120.0f);
}

TEST(SahModel, HasNoLeafAboveTheLimit) {
  const SahModel sah{2.0f, 3.0f, 4};
  EXPECT_EQ(sah.leaf_cost(10.0f, 5), kInfinity);
  EXPECT_EQ(sah.leaf_cost(0.0f, 5), kInfinity);
  EXPECT_EQ(sah.subtree_cost(10.0f, 1000.0f, 5), 1020.0f);
}

TEST(SahModel, TakesTheCheaperOfLeafAndChildren) {
  const SahModel sah{2.0f, 3.0f, 4};
  EXPECT_EQ(sah.subtree_cost(10.0f, 50.0f, 2), 60.0f);  // a leaf: 10 * 3 * 2 < 70
  EXPECT_EQ(sah.subtree_cost(10.0f, 30.0f, 2), 50.0f);  // children: 10 * 2 + 30 < 60
}

}  // namespace
}  // namespace treelet
