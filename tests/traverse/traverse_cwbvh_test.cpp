#include <treelet/traverse/traverse_cwbvh.h>

#include <gtest/gtest.h>

#include <treelet/build/lbvh.h>
#include <treelet/layout/pack_bvh8.h>
#include <treelet/layout/pack_cwbvh.h>
#include <treelet/query/brute_force.h>
#include <treelet/traverse/tracer.h>

#include <cstdint>
#include <string>
#include <vector>

#include "support/aimed_rays.h"
#include "support/exact_ray.h"
#include "support/grid_cases.h"
#include "support/mesh_rays.h"
#include "support/meshes.h"
#include "support/random.h"
#include "support/ray_cases.h"
#include "support/trees.h"

namespace treelet {
namespace {

Cwbvh pack(const test::OwnedMesh& mesh, const BinaryTree& tree, const References& references,
           std::uint32_t leaf_limit = CwbvhNode::kMaxLeaf) {
  CwbvhCostModel model;
  model.leaf_limit = leaf_limit;
  return pack_cwbvh(tree, references, mesh.view(), model);
}
Cwbvh pack(const test::OwnedMesh& mesh, std::uint32_t leaf_limit = CwbvhNode::kMaxLeaf) {
  const References references = create_references(mesh.view());
  return pack(mesh, build_lbvh(references), references, leaf_limit);
}

TEST(TraverseCwbvh, AnswersLikeBruteForce) {
  for (const auto& [name, mesh] : test::hard_meshes()) {
    const std::vector<Ray> rays = test::rays_at(mesh.view(), 60, 7);
    for (const std::uint32_t leaf_limit : {1u, 3u}) {
      const Cwbvh bvh = pack(mesh, leaf_limit);
      Tracer<Cwbvh> tracer(bvh);
      for (std::size_t i = 0; i < rays.size(); ++i) {
        SCOPED_TRACE(name + ", ray " + std::to_string(i) + " of seed 7");
        const Hit expected = intersect_brute_force(mesh.view(), rays[i]);
        ASSERT_EQ(tracer.closest(rays[i]), expected);
        ASSERT_EQ(tracer.any(rays[i]), expected.is_hit());
      }
    }
  }
}

TEST(TraverseCwbvh, AnswersLikeBruteForceToRaysThatGraze) {
  for (const test::Aim aim : test::kAims) {
    const auto [mesh, rays] = test::AimedRays(aim, 500, 8);
    const Cwbvh bvh = pack(mesh);
    Tracer<Cwbvh> tracer(bvh);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      ASSERT_EQ(tracer.closest(rays[i]), intersect_brute_force(mesh.view(), rays[i]))
          << test::name(aim) << ", ray " << i << " of seed 8";
    }
  }
}

TEST(TraverseCwbvh, AnswersLikeBruteForceAtEveryScale) {
  const test::OwnedMesh unit = test::triangle_soup(300, 9);
  for (const float scale : {1e-44f, 1e-38f, 1e-30f, 1e30f, 1e36f}) {
    const test::OwnedMesh mesh = test::scaled(unit, scale);
    const Cwbvh bvh = pack(mesh);
    Tracer<Cwbvh> tracer(bvh);
    const std::vector<Ray> rays = test::rays_at(mesh.view(), 60, 3);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      ASSERT_EQ(tracer.closest(rays[i]), intersect_brute_force(mesh.view(), rays[i]))
          << scale << ", ray " << i << " of seed 3";
    }
  }
}

TEST(TraverseCwbvh, OfEqualTTheSmallerFaceWins) {
  const Cwbvh bvh = pack(test::identical_triangles(300));
  EXPECT_EQ(Tracer<Cwbvh>(bvh).closest({.origin = {0.25f, 0.25f, -3}}).face, 0);
}

// A chain is the deepest tree there is: its stack does not fit inline.
TEST(TraverseCwbvh, WalksAChain) {
  for (const test::OwnedMesh& mesh : {test::triangle_soup(3000, 4), test::equal_centres(400)}) {
    const References references = create_references(mesh.view());
    const Cwbvh bvh = pack(mesh, test::chain_tree(references), references, 1);
    EXPECT_GT(stack_capacity(bvh), 192u);
    Tracer<Cwbvh> tracer(bvh);
    for (const Ray& ray : test::rays_at(mesh.view(), 10, 8)) {
      ASSERT_EQ(tracer.closest(ray), intersect_brute_force(mesh.view(), ray));
    }
  }
}

TEST(TraverseCwbvh, AnEmptyTreeAndBadRaysMiss) {
  const Cwbvh empty;
  Tracer<Cwbvh> nothing(empty);
  EXPECT_FALSE(nothing.closest({}).is_hit());
  EXPECT_FALSE(nothing.any({}));
  EXPECT_EQ(nothing.work({}).nodes, 0u);

  const Cwbvh bvh = pack(test::two_triangles());
  Tracer<Cwbvh> tracer(bvh);
  EXPECT_TRUE(tracer.any({.origin = {0.5f, 0.25f, -1}, .direction = {0, 0, 1}}));
  EXPECT_FALSE(tracer.any({.origin = {0.5f, 0.25f, -1}, .direction = {0, 0, 0}}));
}

/// Work of all rays together.
template <class Layout>
Work total_work(const Layout& bvh, const std::vector<Ray>& rays) {
  Tracer<Layout> tracer(bvh);
  Work total;
  for (const Ray& ray : rays) {
    const Work work = tracer.work(ray);
    total.nodes += work.nodes;
    total.triangles += work.triangles;
  }
  return total;
}

// Boxes are coarser than exact ones, and children are met in the order of octants: each may cost
// some work, but not much.
TEST(TraverseCwbvh, WorksLittleMoreThanTheWideLayoutOfTheSameTree) {
  const test::OwnedMesh mesh = test::icosphere(5);
  const References references = create_references(mesh.view());
  const BinaryTree tree = build_lbvh(references);
  const Cwbvh compressed = pack(mesh, tree, references);
  const Bvh8 exact = pack_bvh8(tree, references, mesh.view(), WideCostModel{.leaf_limit = 3});
  test::Random random(2);
  std::vector<Ray> rays(2000);
  for (Ray& ray : rays) {
    ray.origin = random.point(-2.0f, 2.0f);
    ray.direction = random.point(-0.7f, 0.7f) - ray.origin;
  }
  const Work work = total_work(compressed, rays), wide = total_work(exact, rays);
  EXPECT_LT(work.nodes, 1.15 * wide.nodes);  // in reverse order: 1.35
  EXPECT_LT(work.triangles, 6 * rays.size());
}

class CompressedBoxScale : public testing::TestWithParam<test::Scale> {};

// The box of a child, its decoded one, and the ray: what the first holds, the slab test of the
// second must not lose.
TEST_P(CompressedBoxScale, AreNeverMissedByARayThatMeetsTheChild) {
  test::Random random(5);
  int met = 0, missed = 0;
  for (int i = 0; i < 20000 && !HasFailure(); ++i) {
    const test::GridCase grid = test::random_grid_case(random, GetParam().factor);
    if (!is_traceable(grid.ray)) continue;
    const Aabb decoded = decode_box(grid.node, grid.slot);
    ASSERT_TRUE(decoded.contains(grid.child)) << "seed 5, case " << i;
    const RayBox slabs(grid.ray, grid.scene);
    const bool reported = intersect(slabs, decoded, slabs.lower_limit(grid.ray.t_min),
                                    slabs.upper_limit(grid.ray.t_max))
                              .is_hit();
    const bool meets = test::exact_meets_box(grid.ray, decoded);
    EXPECT_TRUE(reported || !meets) << "seed 5, case " << i;
    met += meets;
    missed += !reported;
  }
  EXPECT_GT(met, 2000);
  EXPECT_GT(missed, 50);
}

INSTANTIATE_TEST_SUITE_P(Scales, CompressedBoxScale, testing::ValuesIn(test::kGridScales),
                         [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace treelet
