#include <treelet/layout/bvh2.h>

#include <gtest/gtest.h>

namespace treelet {
namespace {

const Aabb kBox{{0, 0, 0}, {1, 1, 1}};

TEST(Bvh2, ANodeIsACacheLine) {
  const Array<Bvh2Node> nodes(3);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(nodes.data()) % 64, 0u);
}

TEST(Bvh2, LeavesHaveTriangles) {
  const Bvh2Node node{{kBox, kBox}, {0, 7}, {3, 0}};
  EXPECT_TRUE(node.is_leaf(0));
  EXPECT_FALSE(node.is_leaf(1));
}

TEST(Bvh2, ASingleLeafHasAnEmptySecondChild) {
  Bvh2 bvh;
  EXPECT_FALSE(bvh.is_single_leaf());
  bvh.nodes = Array<Bvh2Node>(1, {{kBox, Aabb::empty()}, {0, 0}, {1, 0}});
  EXPECT_TRUE(bvh.is_single_leaf());
  bvh.nodes[0].box[1] = kBox;
  EXPECT_FALSE(bvh.is_single_leaf());
}

TEST(Bvh2, CountsItsBytes) {
  Bvh2 bvh;
  EXPECT_EQ(bvh.bytes(), 0u);
  bvh.nodes = Array<Bvh2Node>(3);
  bvh.triangles = Array<PackedTriangle>(5);
  EXPECT_EQ(bvh.bytes(), 3u * 64 + 5u * 40);
}

}  // namespace
}  // namespace treelet
