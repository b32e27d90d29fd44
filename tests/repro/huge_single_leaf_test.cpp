#include <gtest/gtest.h>

#include <treelet/pipeline/build.h>
#include <treelet/query/brute_force.h>

#include <array>

namespace treelet {
namespace {

// Coordinate differences beyond the largest float make the slab test say yes to everything, also to
// the empty place beside a tree's only leaf: traversal went round the root for ever.
TEST(Repro, HugeCoordinatesInATreeOfOneLeaf) {
  const std::array<Vec3, 3> vertices{
      {{-3e38f, -3e38f, 3e38f}, {3e38f, -3e38f, 3e38f}, {0, 3e38f, 3e38f}}};
  const std::array<Face, 1> faces{{{0, 1, 2}}};
  const Mesh mesh{vertices, faces};
  for (const char* const recipe : {"lbvh > bvh2", "lbvh > bvh8"}) {
    const Bvh bvh = build(mesh, recipe);
    for (const Vec3 direction : {Vec3{0, 0, 1}, Vec3{0, 0, 1e30f}, Vec3{0, 0, -1}, Vec3{1, 0, 0}}) {
      const Ray ray{.origin = {0, 0, -3e38f}, .direction = direction};
      EXPECT_EQ(bvh.intersect(ray), intersect_brute_force(mesh, ray)) << recipe;
    }
  }
}

}  // namespace
}  // namespace treelet
