#include <treelet/traverse/traverse_bvh8.h>

#include <gtest/gtest.h>

#include <treelet/build/lbvh.h>
#include <treelet/layout/pack_bvh8.h>
#include <treelet/query/brute_force.h>
#include <treelet/traverse/is_traceable.h>
#include <treelet/traverse/tracer.h>

#include <string>
#include <vector>

#include "support/mesh_rays.h"
#include "support/meshes.h"
#include "support/random.h"
#include "support/trees.h"

namespace treelet {
namespace {

std::vector<Isa> runnable_isas() {
  std::vector<Isa> isas;
  for (const Isa isa : {Isa::baseline, Isa::avx2, Isa::avx512}) {
    if (isa <= best_isa()) isas.push_back(isa);
  }
  return isas;
}

TEST(TraverseBvh8, AnswersLikeBruteForceForEveryInstructionSet) {
  for (const auto& [name, mesh] : test::hard_meshes()) {
    const References references = create_references(mesh.view());
    if (references.size() == 0) continue;
    const std::vector<Ray> rays = test::rays_at(mesh.view(), 40, 7);
    for (const std::uint32_t leaf_limit : {1u, 16u}) {
      const Bvh8 bvh =
          pack_bvh8(build_lbvh(references), references, mesh.view(), {.leaf_limit = leaf_limit});
      TraversalStack stack(stack_capacity(bvh));
      for (std::size_t i = 0; i < rays.size(); ++i) {
        if (!is_traceable(rays[i])) continue;
        const Hit expected = intersect_brute_force(mesh.view(), rays[i]);
        for (const Isa isa : runnable_isas()) {
          SCOPED_TRACE(name + ", ray " + std::to_string(i) + " of seed 7, isa " +
                       std::to_string(int(isa)));
          const Bvh8Tracer tracer = bvh8_tracer(isa);
          ASSERT_EQ(tracer.closest(Bvh8View(bvh), rays[i], stack.entries()), expected);
          ASSERT_EQ(tracer.any(Bvh8View(bvh), rays[i], stack.entries()), expected.is_hit());
        }
      }
    }
  }
}

TEST(TraverseBvh8, CountsTheSameWorkForEveryInstructionSet) {
  const test::OwnedMesh mesh = test::triangle_soup(2000, 5);
  const References references = create_references(mesh.view());
  const Bvh8 bvh = pack_bvh8(build_lbvh(references), references, mesh.view(), {});
  TraversalStack stack(stack_capacity(bvh));
  for (const Ray& ray : test::rays_at(mesh.view(), 100, 6)) {
    if (!is_traceable(ray)) continue;
    const Work baseline = bvh8_tracer(Isa::baseline).work(Bvh8View(bvh), ray, stack.entries());
    EXPECT_GE(baseline.nodes, 1u);
    EXPECT_LE(baseline.nodes, bvh.nodes.size());
    EXPECT_LE(baseline.triangles, bvh.blocks.size());
    for (const Isa isa : runnable_isas()) {
      const Work work = bvh8_tracer(isa).work(Bvh8View(bvh), ray, stack.entries());
      ASSERT_EQ(work.nodes, baseline.nodes);
      ASSERT_EQ(work.triangles, baseline.triangles);
    }
  }
}

// A chain is the deepest tree there is: its stack does not fit inline.
TEST(TraverseBvh8, WalksAChain) {
  const test::OwnedMesh mesh = test::triangle_soup(3000, 4);
  const References references = create_references(mesh.view());
  const Bvh8 bvh =
      pack_bvh8(test::chain_tree(references), references, mesh.view(), {.leaf_limit = 1});
  EXPECT_GT(bvh.depth, 200u);
  Tracer<Bvh8> tracer(bvh);
  for (const Ray& ray : test::rays_at(mesh.view(), 10, 8)) {
    ASSERT_EQ(tracer.closest(ray), intersect_brute_force(mesh.view(), ray));
  }
}

TEST(TraverseBvh8, AnEmptyTreeAndBadRaysMiss) {
  const Bvh8 empty;
  Tracer<Bvh8> nothing(empty);
  EXPECT_FALSE(nothing.closest({}).is_hit());
  EXPECT_FALSE(nothing.any({}));
  EXPECT_EQ(nothing.work({}).nodes, 0u);

  const test::OwnedMesh mesh = test::two_triangles();
  const References references = create_references(mesh.view());
  const Bvh8 bvh = pack_bvh8(build_lbvh(references), references, mesh.view(), {});
  Tracer<Bvh8> tracer(bvh);
  EXPECT_TRUE(tracer.any({.origin = {0.5f, 0.25f, -1}, .direction = {0, 0, 1}}));
  EXPECT_FALSE(tracer.any({.origin = {0.5f, 0.25f, -1}, .direction = {0, 0, 0}}));
}

// Boxes are padded by the rounding of the slab test; from a million extents away that would be all
// of the scene, if the test began there.
TEST(TraverseBvh8, AFarOriginStillCulls) {
  const test::OwnedMesh mesh = test::icosphere(5);
  const References references = create_references(mesh.view());
  const Bvh8 bvh = pack_bvh8(build_lbvh(references), references, mesh.view(), {});
  Tracer<Bvh8> tracer(bvh);
  test::Random random(3);
  for (int i = 0; i < 100; ++i) {
    const Vec3 target = random.point(-0.6f, 0.6f), away = random.point(-1.0f, 1.0f);
    const Ray ray{.origin = target + away * 1e6f, .direction = away * -1.0f};
    ASSERT_EQ(tracer.closest(ray), intersect_brute_force(mesh.view(), ray)) << "seed 3, ray " << i;
    ASSERT_LT(tracer.work(ray).nodes, bvh.nodes.size() / 10) << "seed 3, ray " << i;
  }
}

}  // namespace
}  // namespace treelet
