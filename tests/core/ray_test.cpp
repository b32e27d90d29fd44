#include <treelet/core/ray.h>

#include <gtest/gtest.h>

namespace treelet {
namespace {

TEST(Ray, IsEndlessByDefault) {
  const Ray ray;
  EXPECT_EQ(ray.t_min, 0.0f);
  EXPECT_EQ(ray.t_max, std::numeric_limits<float>::infinity());
}

TEST(Hit, IsAMissByDefault) {
  const Hit miss;
  EXPECT_FALSE(miss.is_hit());
  EXPECT_EQ(miss.t, std::numeric_limits<float>::infinity());
  EXPECT_EQ(miss.face, -1);
}

TEST(Hit, OfFaceZeroIsAHit) { EXPECT_TRUE((Hit{1.0f, 0, 0.25f, 0.5f}).is_hit()); }

}  // namespace
}  // namespace treelet
