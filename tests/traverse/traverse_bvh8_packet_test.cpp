// Coherent rays go through the tree in packets; their answers are those of single rays.

#include <treelet/traverse/traverse_bvh8.h>

#include <gtest/gtest.h>

#include <treelet/build/lbvh.h>
#include <treelet/layout/pack_bvh8.h>

#include <algorithm>
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

namespace treelet {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

Bvh8 build(const Mesh& mesh) {
  const References references = create_references(mesh);
  return pack_bvh8(build_lbvh(references), references, mesh, WideCostModel{});
}

template <class Answer>
std::vector<Answer> trace(Bvh8Tracer::Trace<Answer> kernel, const Bvh8& bvh,
                          std::span<const Ray> rays, std::size_t at_once) {
  WaveStacks stacks(bvh, at_once);
  const auto answers = std::make_unique<Answer[]>(rays.size());
  for (std::size_t i = 0; i < rays.size(); i += at_once) {
    const std::size_t count = std::min(at_once, rays.size() - i);
    kernel(Bvh8View(bvh), rays.data() + i, count, answers.get() + i, stacks.view());
  }
  return std::vector<Answer>(answers.get(), answers.get() + rays.size());
}

/// Rays one at a time are no packets.
void expect_single_answers(const Bvh8& bvh, std::span<const Ray> rays) {
  const std::vector<Hit> hits = trace(bvh8_tracer(Isa::baseline).closest, bvh, rays, 1);
  const std::vector<bool> found = trace(bvh8_tracer(Isa::baseline).any, bvh, rays, 1);
  for (const Isa isa : test::runnable_isas()) {
    SCOPED_TRACE("isa " + std::to_string(int(isa)));
    const std::vector<Hit> packed = trace(bvh8_tracer(isa).closest, bvh, rays, rays.size());
    const std::vector<bool> packed_found = trace(bvh8_tracer(isa).any, bvh, rays, rays.size());
    for (std::size_t i = 0; i < rays.size(); ++i) {
      ASSERT_EQ(packed[i], hits[i]) << "ray " << i;
      ASSERT_EQ(packed_found[i], found[i]) << "ray " << i;
    }
  }
}

/// `count` rays close to `ray`, itself among them.
void add_bundle(std::vector<Ray>& rays, const Ray& ray, std::size_t count, float spread,
                test::Random& random) {
  const float length = max_component(
      {std::fabs(ray.direction.x), std::fabs(ray.direction.y), std::fabs(ray.direction.z)});
  for (std::size_t i = 0; i < count; ++i) {
    Ray copy = ray;
    if (i != 0) copy.direction = copy.direction + random.point(-spread, spread) * length;
    rays.push_back(copy);
  }
}

TEST(TraverseBvh8Packet, AnswersLikeSingleRays) {
  for (const auto& [name, mesh] : test::hard_meshes()) {
    SCOPED_TRACE(name + ", rays of seed 7");
    if (create_references(mesh.view()).size() == 0) continue;
    const Bvh8 bvh = build(mesh.view());
    test::Random random(7);
    for (const float spread : {0.0f, 1e-6f, 1e-3f, 0.05f}) {
      std::vector<Ray> rays;
      for (const Ray& ray : test::rays_at(mesh.view(), 6, 7)) {
        add_bundle(rays, ray, 16, spread, random);
      }
      expect_single_answers(bvh, rays);
    }
  }
}

// Packets from one point, to all sides: through axes, over octants and edges of the mesh.
TEST(TraverseBvh8Packet, AnswersLikeSingleRaysForCameras) {
  const test::OwnedMesh meshes[] = {test::icosphere(4), test::triangle_soup(2000, 5),
                                    test::coplanar_grid(20)};
  for (const test::OwnedMesh& mesh : meshes) {
    const Bvh8 bvh = build(mesh.view());
    for (const Vec3 eye : {Vec3{0, 0, 0}, Vec3{0.3f, 0.2f, 2}, Vec3{0.5f, -1.5f, 0.5f}}) {
      std::vector<Ray> rays;
      for (int y = -40; y <= 40; ++y) {
        for (int x = -64; x < 64; ++x) {
          const Vec3 target{0.02f * float(x), 0.02f * float(y), 0.1f};
          rays.push_back({.origin = eye, .direction = target - eye * 0.5f});
        }
      }
      expect_single_answers(bvh, rays);
    }
  }
}

TEST(TraverseBvh8Packet, LimitsMayBeAHitsOwnTime) {
  const test::OwnedMesh mesh = test::icosphere(3);
  const Bvh8 bvh = build(mesh.view());
  test::Random random(9);
  std::vector<Ray> rays;
  add_bundle(rays, {.origin = {0.2f, 0.1f, 4}, .direction = {-0.02f, 0.01f, -1}}, 640, 0.05f,
             random);
  const std::vector<Hit> hits = trace(bvh8_tracer(Isa::baseline).closest, bvh, rays, 1);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const float t = hits[i].t;
    const float limits[] = {std::nextafter(t, -kInfinity), t, std::nextafter(t, kInfinity)};
    if (i % 2 == 0) rays[i].t_max = limits[i / 2 % 3];
    if (i % 2 == 1) rays[i].t_min = limits[i / 2 % 3];
  }
  expect_single_answers(bvh, rays);
}

// Bad rays, rays from far away, huge and tiny directions and infinite limits amid coherent ones.
TEST(TraverseBvh8Packet, OddRaysAmongCoherentOnes) {
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  const test::OwnedMesh mesh = test::icosphere(3);
  const Bvh8 bvh = build(mesh.view());
  const Ray ray{.origin = {0.2f, 0.1f, 4}, .direction = {-0.02f, 0.01f, -1}};
  const Ray odd[] = {{{nan, 0, 4}, ray.direction, 0, kInfinity},
                     {ray.origin, {0, 0, 0}, 0, kInfinity},
                     {ray.origin, {0, nan, -1}, 0, kInfinity},
                     {ray.origin, ray.direction, 2, 1},
                     {ray.origin, ray.direction, 0, nan},
                     {{0, 0, 4e6f}, {0, 0, -1}, 0, kInfinity},
                     {ray.origin, {0, 0, -1e-38f}, 0, kInfinity},
                     {ray.origin, {0, 0, -1e-45f}, 0, kInfinity},
                     {ray.origin, {0, 0, -3e38f}, 0, kInfinity},
                     {ray.origin, {-0.0f, 0, -1}, 0, kInfinity},
                     {ray.origin, ray.direction, -kInfinity, 5},
                     {ray.origin, ray.direction, 0, -kInfinity},
                     {ray.origin, ray.direction, kInfinity, kInfinity},
                     {{3e38f, 0, 4}, ray.direction, 0, kInfinity},
                     {ray.origin, {kInfinity, 0, -1}, 0, kInfinity},
                     {ray.origin, {0, 0, 1}, -9, kInfinity}};
  test::Random random(4);
  std::vector<Ray> rays;
  for (const Ray& other : odd) {
    for (const std::size_t place : {0u, 3u, 15u}) {
      add_bundle(rays, ray, 16, 0.01f, random);
      rays[rays.size() - 16 + place] = other;
    }
    for (int i = 0; i < 16; ++i) rays.push_back(other);  // a packet of nothing else
  }
  expect_single_answers(bvh, rays);
}

// Mixed with incoherent rays, and with groups that are not full.
TEST(TraverseBvh8Packet, AnyNumberOfRaysInAnyMixture) {
  const test::OwnedMesh mesh = test::triangle_soup(2000, 5);
  const Bvh8 bvh = build(mesh.view());
  test::Random random(3);
  std::vector<Ray> rays;
  for (const Ray& ray : test::rays_at(mesh.view(), 60, 3)) {
    add_bundle(rays, ray, 1 + random.below(40), random.below(2) == 0 ? 0.02f : 2.0f, random);
  }
  SCOPED_TRACE("rays of seed 3");
  for (const std::size_t count : {std::size_t{1}, std::size_t{7}, std::size_t{17},
                                  std::size_t{1023}, std::size_t{1025}, rays.size()}) {
    expect_single_answers(bvh, std::span(rays).first(std::min(count, rays.size())));
  }
}

// A packet wider than the triangles gives up, and its rays go on from what it has found.
TEST(TraverseBvh8Packet, GivesUpAmongSmallTriangles) {
  const test::OwnedMesh mesh = test::triangle_soup(50000, 8);
  const Bvh8 bvh = build(mesh.view());
  test::Random random(5);
  std::vector<Ray> rays;
  add_bundle(rays, {.origin = {0.5f, 0.5f, 3}, .direction = {0.01f, -0.01f, -1}}, 1024, 0.1f,
             random);
  expect_single_answers(bvh, rays);
}

// Coordinates so large that boxes are a few ulps wide.
TEST(TraverseBvh8Packet, AFarMeshIsHitAllTheSame) {
  const test::OwnedMesh mesh = test::translated(test::icosphere(3), {5e6f, -3e6f, 1e6f});
  const Bvh8 bvh = build(mesh.view());
  test::Random random(6);
  std::vector<Ray> rays;
  add_bundle(rays, {.origin = {5e6f, -3e6f, 1e6f + 4}, .direction = {0, 0, -1}}, 512, 0.1f, random);
  expect_single_answers(bvh, rays);
}

}  // namespace
}  // namespace treelet
