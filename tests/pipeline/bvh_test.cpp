#include <treelet/pipeline/bvh.h>

#include <gtest/gtest.h>

#include <treelet/pipeline/build.h>

#include <thread>
#include <utility>
#include <vector>

#include "support/mesh_rays.h"
#include "support/meshes.h"

namespace treelet {
namespace {

TEST(Bvh, OfNothingIsMissed) {
  const Bvh bvh;
  EXPECT_FALSE(bvh.intersect(Ray{}).is_hit());
  EXPECT_FALSE(bvh.is_occluded(Ray{}));
  EXPECT_EQ(bvh.intersect(std::vector<Ray>(3)), std::vector<Hit>(3));
}

TEST(Bvh, OutlivesItsMeshAndMoves) {
  Bvh bvh;
  {
    const test::OwnedMesh mesh = test::one_triangle();
    bvh = build(mesh.view());
  }
  const Bvh moved = std::move(bvh);
  EXPECT_EQ(moved.intersect({.origin = {0.25f, 0.25f, -1}}).face, 0);
  EXPECT_TRUE(moved.is_occluded({.origin = {0.25f, 0.25f, -1}}));
}

TEST(Bvh, ManyThreadsMayAskAtOnce) {
  const test::OwnedMesh mesh = test::triangle_soup(500, 1);
  const Bvh bvh = build(mesh.view());
  const std::vector<Ray> rays = test::rays_at(mesh.view(), 200, 2);
  const std::vector<Hit> expected = bvh.intersect(rays);
  std::vector<std::vector<Hit>> answers(4);
  std::vector<std::thread> threads;
  for (std::vector<Hit>& answer : answers) {
    threads.emplace_back([&] { answer = bvh.intersect(rays); });
  }
  for (std::thread& thread : threads) thread.join();
  for (const std::vector<Hit>& answer : answers) EXPECT_EQ(answer, expected);
}

}  // namespace
}  // namespace treelet
