#include <treelet/traverse/traverse_bvh2.h>

#include <gtest/gtest.h>

#include <treelet/build/lbvh.h>
#include <treelet/layout/pack_bvh2.h>
#include <treelet/query/brute_force.h>

#include <limits>
#include <string>
#include <vector>

#include "support/meshes.h"
#include "support/random.h"
#include "support/trees.h"

namespace treelet {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

template <class Visitor = ClosestHit<>>
Visitor trace(const Bvh2& bvh, const Ray& ray) {
  TraversalStack stack(bvh.depth);
  Visitor visitor(ray);
  traverse(bvh, ray, stack, visitor);
  return visitor;
}

Bvh2 pack(const test::OwnedMesh& mesh, std::uint32_t leaf_limit = 8) {
  const References references = create_references(mesh.view());
  return pack_bvh2(build_lbvh(references), references, mesh.view(), {.leaf_limit = leaf_limit});
}

TEST(IsTraceable, WantsAFiniteRayAndAnInterval) {
  const Ray good{.origin = {1, 2, 3}, .direction = {0, -1, 0}, .t_min = 0, .t_max = kInfinity};
  EXPECT_TRUE(is_traceable(good));
  for (const float bad : {kNan, kInfinity, -kInfinity}) {
    for (int part = 0; part < 6; ++part) {
      Ray ray = good;
      float* const components[] = {&ray.origin.x,    &ray.origin.y,    &ray.origin.z,
                                   &ray.direction.x, &ray.direction.y, &ray.direction.z};
      *components[part] = bad;
      EXPECT_FALSE(is_traceable(ray)) << bad << " in component " << part;
    }
  }
  const auto with_limits = [&](float t_min, float t_max) {
    return is_traceable({good.origin, good.direction, t_min, t_max});
  };
  EXPECT_TRUE(with_limits(-kInfinity, kInfinity));
  EXPECT_TRUE(with_limits(2, 2));
  EXPECT_FALSE(with_limits(2, 1));
  EXPECT_FALSE(with_limits(kNan, 1));
  EXPECT_FALSE(with_limits(0, kNan));
  EXPECT_FALSE(is_traceable({good.origin, {0, 0, 0}}));
  EXPECT_FALSE(is_traceable({good.origin, {-0.0f, 0, -0.0f}}));
  EXPECT_TRUE(is_traceable({good.origin, {0, 0, std::numeric_limits<float>::denorm_min()}}));
  EXPECT_TRUE(is_traceable({{3e38f, 3e38f, 3e38f}, {3e38f, 3e38f, 3e38f}}));
}

TEST(TraverseBvh2, RaysThatAreNoRaysMiss) {
  const Bvh2 bvh = pack(test::icosphere(1));
  for (const float bad : {kNan, kInfinity}) {
    EXPECT_EQ(trace(bvh, {.origin = {bad, 0, 0}}).hit, Hit{});
    EXPECT_EQ(trace(bvh, {.origin = {0, 0, 0}, .direction = {bad, 0, 0}}).hit, Hit{});
    EXPECT_FALSE(trace<AnyHit>(bvh, {.origin = {0, bad, 0}}).found);
  }
  EXPECT_EQ(trace(bvh, {.origin = {0, 0, 0}, .direction = {0, 0, 0}}).hit, Hit{});
  EXPECT_EQ(trace(bvh, {.t_min = kNan}).hit, Hit{});
  EXPECT_EQ(trace(bvh, {.t_min = 2, .t_max = 1}).hit, Hit{});
}

TEST(TraverseBvh2, NothingIsMissedByAll) {
  EXPECT_EQ(trace(Bvh2{}, {.origin = {0, 0, 0}}).hit, Hit{});
  EXPECT_FALSE(trace<AnyHit>(Bvh2{}, {.origin = {0, 0, 0}}).found);
}

/// Unit squares in z = 1, 2, 3 ..., two triangles each.
test::OwnedMesh stack_of_squares(int count) {
  test::OwnedMesh mesh;
  for (int i = 1; i <= count; ++i) {
    const float z = float(i);
    mesh.add({0, 0, z}, {1, 0, z}, {1, 1, z});
    mesh.add({0, 0, z}, {1, 1, z}, {0, 1, z});
  }
  return mesh;
}

TEST(TraverseBvh2, LimitsAreInclusive) {
  const Bvh2 bvh = pack(stack_of_squares(20), 1);
  const auto hit_between = [&](float t_min, float t_max) {
    return trace(bvh, {{0.75f, 0.25f, 0}, {0, 0, 1}, t_min, t_max}).hit;
  };
  EXPECT_EQ(hit_between(0, kInfinity), (Hit{1, 0, 0.5f, 0.25f}));
  EXPECT_EQ(hit_between(5, kInfinity).face, 8);
  EXPECT_EQ(hit_between(5, 5).face, 8);
  EXPECT_EQ(hit_between(std::nextafter(5.0f, 6.0f), 6).face, 10);
  EXPECT_EQ(hit_between(5.25f, 5.75f), Hit{});
  EXPECT_EQ(hit_between(0, std::nextafter(1.0f, 0.0f)), Hit{});
  EXPECT_EQ(hit_between(-kInfinity, kInfinity).t, 1.0f);
  EXPECT_EQ(trace(bvh, {{0.75f, 0.25f, 10.5f}, {0, 0, 1}, -3, 0}).hit.t, -2.5f);
}

TEST(TraverseBvh2, OfEqualTTheSmallerFaceWins) {
  test::OwnedMesh mesh = test::identical_triangles(300);
  for (const std::uint32_t leaf_limit : {1u, 8u}) {
    const Bvh2 bvh = pack(mesh, leaf_limit);
    const Hit hit = trace(bvh, {.origin = {0.25f, 0.25f, -3}}).hit;
    EXPECT_EQ(hit.face, 0) << "leaf limit " << leaf_limit;
  }
  const Bvh2 squares = pack(stack_of_squares(9), 1);
  EXPECT_EQ(trace(squares, {.origin = {0.5f, 0.5f, 4.5f}}).hit.face, 8);  // on the diagonal of two
}

TEST(TraverseBvh2, TreesDeeperThanTheInlineStack) {
  const test::OwnedMesh mesh = stack_of_squares(500);
  const References references = create_references(mesh.view());
  const Bvh2 bvh =
      pack_bvh2(test::chain_tree(references), references, mesh.view(), {.leaf_limit = 1});
  ASSERT_GT(bvh.depth, 900u);
  test::Random random(1);
  for (int i = 0; i < 300; ++i) {
    SCOPED_TRACE("seed 1, case " + std::to_string(i));
    Ray ray;
    ray.origin = {random.uniform(-0.2f, 1.2f), random.uniform(-0.2f, 1.2f),
                  random.uniform(-5.0f, 505.0f)};
    ray.direction = {random.uniform(-1e-3f, 1e-3f), random.uniform(-1e-3f, 1e-3f),
                     i % 2 == 0 ? 1.0f : -1.0f};
    const Hit expected = intersect_brute_force(mesh.view(), ray);
    EXPECT_EQ(trace(bvh, ray).hit, expected);
    EXPECT_EQ(trace<AnyHit>(bvh, ray).found, expected.is_hit());
  }
}

// Nested boxes: at every node of the chain both children are met.
TEST(TraverseBvh2, EveryLevelOfADeepTreeMayWait) {
  const test::OwnedMesh mesh = test::equal_centres(400);
  const References references = create_references(mesh.view());
  test::Random random(2);
  const Bvh2 bvh =
      pack_bvh2(test::chain_tree(references), references, mesh.view(), {.leaf_limit = 1});
  for (int i = 0; i < 200; ++i) {
    SCOPED_TRACE("seed 2, case " + std::to_string(i));
    const Vec3 origin = random.point(-2.0f, 2.0f);
    const Ray ray{.origin = origin, .direction = random.point(-0.3f, 0.3f) - origin};
    EXPECT_EQ(trace(bvh, ray).hit, intersect_brute_force(mesh.view(), ray));
  }
}

TEST(TraverseBvh2, StopsEarly) {
  const Bvh2 bvh = pack(stack_of_squares(1000));
  const Work work = trace<ClosestHit<Counting>>(bvh, {.origin = {0.75f, 0.25f, 0}}).work;
  EXPECT_GT(work.nodes, 0u);
  EXPECT_LT(work.nodes, 40u);
  EXPECT_GT(work.triangles, 0u);
  EXPECT_LT(work.triangles, 40u);
  const Work beside = trace<ClosestHit<Counting>>(bvh, {.origin = {5, 5, 0}}).work;
  EXPECT_EQ(beside.nodes, 1u);
  EXPECT_EQ(beside.triangles, 0u);
}

}  // namespace
}  // namespace treelet
