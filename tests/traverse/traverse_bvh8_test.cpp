#include <treelet/traverse/traverse_bvh8.h>

#include <gtest/gtest.h>

#include <treelet/build/lbvh.h>
#include <treelet/layout/pack_bvh8.h>
#include <treelet/query/brute_force.h>
#include <treelet/traverse/is_traceable.h>
#include <treelet/traverse/tracer.h>

#include <cmath>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "support/isas.h"
#include "support/mesh_rays.h"
#include "support/meshes.h"
#include "support/random.h"
#include "support/trees.h"

namespace treelet {
namespace {

template <class Answer>
std::vector<Answer> trace(Bvh8Tracer::Trace<Answer> kernel, const Bvh8& bvh,
                          std::span<const Ray> rays) {
  WaveStacks stacks(bvh, rays.size());
  const auto answers = std::make_unique<Answer[]>(rays.size());
  kernel(Bvh8View(bvh), rays.data(), rays.size(), answers.get(), stacks.view());
  return std::vector<Answer>(answers.get(), answers.get() + rays.size());
}

std::vector<Hit> brute_force(const Mesh& mesh, std::span<const Ray> rays) {
  std::vector<Hit> hits;
  for (const Ray& ray : rays) hits.push_back(intersect_brute_force(mesh, ray));
  return hits;
}

/// With every kernel that runs here, all rays at once.
void expect_answers(const Bvh8& bvh, std::span<const Ray> rays, const std::vector<Hit>& expected) {
  for (const Isa isa : test::runnable_isas()) {
    SCOPED_TRACE("isa " + std::to_string(int(isa)));
    const std::vector<Hit> hits = trace(bvh8_tracer(isa).closest, bvh, rays);
    const std::vector<bool> occluded = trace(bvh8_tracer(isa).any, bvh, rays);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      ASSERT_EQ(hits[i], expected[i]) << "ray " << i;
      ASSERT_EQ(occluded[i], expected[i].is_hit()) << "ray " << i;
    }
  }
}

TEST(TraverseBvh8, AnswersLikeBruteForceForEveryInstructionSet) {
  for (const auto& [name, mesh] : test::hard_meshes()) {
    SCOPED_TRACE(name + ", rays of seed 7");
    const References references = create_references(mesh.view());
    if (references.size() == 0) continue;
    const std::vector<Ray> rays = test::rays_at(mesh.view(), 40, 7);
    const std::vector<Hit> expected = brute_force(mesh.view(), rays);
    for (const std::uint32_t leaf_limit : {1u, 16u}) {
      const Bvh8 bvh = pack_bvh8(build_lbvh(references), references, mesh.view(),
                                 WideCostModel{.leaf_limit = leaf_limit});
      expect_answers(bvh, rays, expected);
    }
  }
}

// Floats decide most limits on t; those that are a hit's own t, and its neighbours, are for
// doubles.
TEST(TraverseBvh8, LimitsMayBeAHitsOwnTime) {
  constexpr float inf = std::numeric_limits<float>::infinity();
  for (const auto& [name, mesh] : test::hard_meshes()) {
    SCOPED_TRACE(name + ", rays of seed 9");
    const References references = create_references(mesh.view());
    if (references.size() == 0) continue;
    std::vector<Ray> rays;
    for (const Ray& ray : test::rays_at(mesh.view(), 10, 9)) {
      const Hit hit = intersect_brute_force(mesh.view(), ray);
      if (!hit.is_hit()) continue;
      for (const float t : {std::nextafter(hit.t, -inf), hit.t, std::nextafter(hit.t, inf)}) {
        rays.push_back({ray.origin, ray.direction, ray.t_min, t});
        rays.push_back({ray.origin, ray.direction, t, ray.t_max});
        rays.push_back({ray.origin, ray.direction, t, t});
      }
    }
    const Bvh8 bvh = pack_bvh8(build_lbvh(references), references, mesh.view(), WideCostModel{});
    expect_answers(bvh, rays, brute_force(mesh.view(), rays));
  }
}

TEST(TraverseBvh8, ARayAloneIsAnsweredAsInABatch) {
  const test::OwnedMesh mesh = test::triangle_soup(2000, 5);
  const References references = create_references(mesh.view());
  const Bvh8 bvh = pack_bvh8(build_lbvh(references), references, mesh.view(), WideCostModel{});
  const std::vector<Ray> rays = test::rays_at(mesh.view(), 100, 3);
  for (const Isa isa : test::runnable_isas()) {
    const std::vector<Hit> hits = trace(bvh8_tracer(isa).closest, bvh, rays);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const std::vector<Hit> alone =
          trace(bvh8_tracer(isa).closest, bvh, std::span(rays).subspan(i, 1));
      ASSERT_EQ(alone[0], hits[i]) << "seed 3, ray " << i << ", isa " << int(isa);
    }
  }
}

TEST(TraverseBvh8, CountsTheSameWorkForEveryInstructionSet) {
  const test::OwnedMesh mesh = test::triangle_soup(2000, 5);
  const References references = create_references(mesh.view());
  const Bvh8 bvh = pack_bvh8(build_lbvh(references), references, mesh.view(), WideCostModel{});
  const std::vector<Ray> rays = test::rays_at(mesh.view(), 100, 6);
  const std::vector<Work> baseline = trace(bvh8_tracer(Isa::baseline).work, bvh, rays);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    EXPECT_EQ(baseline[i].nodes >= 1, is_traceable(rays[i]));
    EXPECT_LE(baseline[i].nodes, bvh.nodes.size());
    EXPECT_LE(baseline[i].triangles, 4 * bvh.blocks.size());
  }
  for (const Isa isa : test::runnable_isas()) {
    const std::vector<Work> work = trace(bvh8_tracer(isa).work, bvh, rays);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      ASSERT_EQ(work[i].nodes, baseline[i].nodes) << "seed 6, ray " << i;
      ASSERT_EQ(work[i].triangles, baseline[i].triangles) << "seed 6, ray " << i;
    }
  }
}

// A chain is the deepest tree there is: its stack does not fit inline.
TEST(TraverseBvh8, WalksAChain) {
  const test::OwnedMesh mesh = test::triangle_soup(3000, 4);
  const References references = create_references(mesh.view());
  const Bvh8 bvh = pack_bvh8(test::chain_tree(references), references, mesh.view(),
                             WideCostModel{.leaf_limit = 1});
  EXPECT_GT(bvh.depth, 200u);
  const std::vector<Ray> rays = test::rays_at(mesh.view(), 10, 8);
  expect_answers(bvh, rays, brute_force(mesh.view(), rays));
  Tracer<Bvh8> tracer(bvh);
  for (const Ray& ray : rays) {
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
  const Bvh8 bvh = pack_bvh8(build_lbvh(references), references, mesh.view(), WideCostModel{});
  Tracer<Bvh8> tracer(bvh);
  EXPECT_TRUE(tracer.any({.origin = {0.5f, 0.25f, -1}, .direction = {0, 0, 1}}));
  EXPECT_FALSE(tracer.any({.origin = {0.5f, 0.25f, -1}, .direction = {0, 0, 0}}));
}

// Boxes are padded by the rounding of the slab test; from a million extents away that would be all
// of the scene, if the test began there.
TEST(TraverseBvh8, AFarOriginStillCulls) {
  const test::OwnedMesh mesh = test::icosphere(5);
  const References references = create_references(mesh.view());
  const Bvh8 bvh = pack_bvh8(build_lbvh(references), references, mesh.view(), WideCostModel{});
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
