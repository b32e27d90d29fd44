#include <treelet/pipeline/update.h>

#include <gtest/gtest.h>

#include <treelet/layout/validate_layout.h>
#include <treelet/query/brute_force.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <new>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include "support/errors.h"
#include "support/layouts.h"
#include "support/mesh_rays.h"
#include "support/meshes.h"
#include "support/recipes.h"
#include "support/threads.h"

namespace treelet {
namespace {

using Sentences = std::vector<std::string>;

/// The facts of a report that are no times.
std::vector<double> facts(const BuildReport& report) {
  std::vector<double> facts{double(report.faces),
                            double(report.references),
                            double(report.left_out_non_finite),
                            double(report.left_out_degenerate),
                            report.sah,
                            double(report.tree.nodes),
                            double(report.tree.leaves),
                            double(report.tree.triangles),
                            double(report.tree.bytes),
                            double(report.tree.depth),
                            report.tree.sah};
  for (const std::size_t leaves : report.tree.leaf_histogram) facts.push_back(double(leaves));
  return facts;
}

/// Waves run through the mesh; frame 0 is the mesh as it is.
test::OwnedMesh frame(test::OwnedMesh mesh, int number) {
  const float t = 0.4f * float(number);
  for (Vec3& p : mesh.vertices) {
    p = p + Vec3{0.2f * t * std::sin(3.0f * p.y + t), t * p.x, 0.3f * t * std::cos(4.0f * p.x)};
  }
  return mesh;
}

void expect_hits(const Bvh& bvh, const Mesh& mesh, std::uint64_t seed) {
  for (const Ray& ray : test::rays_at(mesh, 20, seed)) {
    ASSERT_EQ(bvh.intersect(ray), intersect_brute_force(mesh, ray)) << "seed " << seed;
  }
}

TEST(UpdatableBvh, IsBuiltLikeAnyTree) {
  const test::OwnedMesh mesh = test::triangle_soup(2000, 1);
  for (const std::string& recipe : test::every_recipe()) {
    const UpdatableBvh tree(mesh.view(), recipe);
    const Bvh expected = build(mesh.view(), recipe);
    EXPECT_TRUE(test::equal_bytes(tree.bvh(), expected)) << recipe;
    EXPECT_EQ(facts(tree.bvh().report), facts(expected.report)) << recipe;
    EXPECT_EQ(tree.bvh().report.update.refits, 0u);
    EXPECT_EQ(tree.bvh().report.update.sah, expected.report.tree.sah);
  }
}

TEST(UpdatableBvh, ARebuildIsANewBuild) {
  const test::OwnedMesh mesh = test::triangle_soup(2000, 2);
  for (const std::string& recipe : test::every_recipe()) {
    UpdatableBvh tree(mesh.view(), recipe);
    for (const int number : {1, 2, 3}) {
      const test::OwnedMesh moved = frame(mesh, number);
      if (number == 2) tree.refit(frame(mesh, 5).vertices);
      tree.rebuild(moved.vertices);
      const Bvh expected = build(moved.view(), recipe);
      EXPECT_TRUE(test::equal_bytes(tree.bvh(), expected)) << recipe << ", frame " << number;
      EXPECT_EQ(facts(tree.bvh().report), facts(expected.report)) << recipe;
      EXPECT_EQ(tree.bvh().report.recipe, expected.report.recipe);
      EXPECT_EQ(tree.bvh().report.update.refits, 0u);
    }
  }
}

TEST(UpdatableBvh, ARebuildDoesNotReadWhatTheLastOneLeft) {
  // Rebuilds over garbage: a stage that reads what it did not write gives other bytes.
  const test::OwnedMesh mesh = test::triangle_soup(3000, 3);
  const auto arena = std::make_shared<Arena>();
  for (const char* const recipe : {"lbvh > treelet > bvh8", "sweep > treelet > bvh2"}) {
    const Bvh expected = build(mesh.view(), recipe);
    for (const int garbage : {0x00, 0x7f, 0xff}) {
      const ArenaScope scope(arena);
      {
        std::vector<Array<unsigned char>> blocks;
        for (std::size_t bytes = 1 << 10; bytes <= std::size_t{1} << 19; bytes *= 2) {
          for (int i = 0; i < 4; ++i) {
            blocks.emplace_back(bytes);
            std::memset(blocks.back().data(), garbage, bytes);
          }
        }
      }
      const std::size_t before = arena->bytes();
      EXPECT_TRUE(test::equal_bytes(build(mesh.view(), recipe), expected))
          << recipe << ", " << garbage;
      EXPECT_LT(arena->bytes() - before, before / 10);
    }
  }
}

TEST(UpdatableBvh, ARefitAnswersLikeBruteForce) {
  const test::OwnedMesh mesh = test::triangle_soup(500, 4);
  for (const char* const recipe : {"lbvh > bvh2", "balanced"}) {
    UpdatableBvh tree(mesh.view(), recipe);
    const double at_build = tree.bvh().report.tree.sah;
    for (const int number : {1, 4, 0}) {
      const test::OwnedMesh moved = frame(mesh, number);
      tree.refit(moved.vertices);
      EXPECT_EQ(tree.bvh().validate(moved.view()), Sentences{});
      expect_hits(tree.bvh(), moved.view(), 5);
      const BuildReport& report = tree.bvh().report;
      EXPECT_EQ(report.tree.sah, at_build);
      const double expected = std::visit(
          [&](const auto& layout) { return compute_statistics(layout, tree.bvh().sah).sah; },
          tree.bvh().layout);
      EXPECT_NEAR(report.update.sah, expected, 1e-9 * expected);
      EXPECT_EQ(std::abs(report.update.sah - at_build) < 1e-9 * at_build, number == 0);
      EXPECT_GT(report.update.seconds, 0.0);
    }
    EXPECT_EQ(tree.bvh().report.update.refits, 3u);
    EXPECT_TRUE(test::equal_bytes(tree.bvh(), build(mesh.view(), recipe)));
  }
}

TEST(UpdatableBvh, RefitsOfEveryRecipeAnswerLikeBruteForce) {
  const test::OwnedMesh mesh = test::triangle_soup(300, 4);
  const test::OwnedMesh moved = frame(mesh, 3);
  const std::vector<Ray> rays = test::rays_at(moved.view(), 20, 5);
  std::vector<Hit> expected;
  for (const Ray& ray : rays) expected.push_back(intersect_brute_force(moved.view(), ray));
  for (const std::string& recipe : test::every_recipe()) {
    UpdatableBvh tree(mesh.view(), recipe);
    tree.refit(moved.vertices);
    EXPECT_EQ(tree.bvh().intersect(rays), expected) << recipe << ", seed 5";
    EXPECT_EQ(tree.bvh().validate(moved.view()), Sentences{}) << recipe;
  }
}

TEST(UpdatableBvh, BadTrianglesAreHiddenByRefitAndLeftOutByRebuild) {
  const test::OwnedMesh mesh = test::triangle_soup(600, 3);
  const test::OwnedMesh bad = test::soup_with_bad_faces(600, 3);
  UpdatableBvh tree(mesh.view());
  tree.refit(bad.vertices);
  const std::size_t hidden = tree.bvh().report.update.hidden;
  EXPECT_GT(hidden, 200u);
  EXPECT_EQ(tree.bvh().report.left_out_non_finite, 0u);
  EXPECT_EQ(tree.bvh().validate(), Sentences{});
  expect_hits(tree.bvh(), bad.view(), 7);

  tree.rebuild(bad.vertices);
  const BuildReport& report = tree.bvh().report;
  EXPECT_EQ(report.left_out_non_finite + report.left_out_degenerate, hidden);
  EXPECT_EQ(report.update.hidden, 0u);
  expect_hits(tree.bvh(), bad.view(), 7);

  tree.refit(mesh.vertices);  // left out at the build: still out
  EXPECT_EQ(tree.bvh().report.references, 600u - hidden);
  EXPECT_EQ(tree.bvh().report.update.hidden, 0u);
  tree.rebuild(mesh.vertices);
  EXPECT_EQ(tree.bvh().report.references, 600u);
  expect_hits(tree.bvh(), mesh.view(), 7);
}

TEST(UpdatableBvh, HardMeshesCanBeUpdated) {
  for (const test::NamedMesh& named : test::hard_meshes()) {
    for (const char* const recipe : {"fast", "balanced", "sweep > bvh2"}) {
      SCOPED_TRACE(named.name + ", " + recipe);
      const Mesh mesh = named.mesh.view();
      UpdatableBvh tree(mesh, recipe);
      const test::OwnedMesh moved = frame(named.mesh, 1);
      tree.refit(moved.vertices);
      EXPECT_EQ(tree.bvh().validate(), Sentences{});
      tree.rebuild(moved.vertices);
      EXPECT_EQ(tree.bvh().validate(moved.view()), Sentences{});
      std::vector<Vec3> point(mesh.vertices.size(), Vec3{1, 2, 3});
      tree.refit(point);
      EXPECT_EQ(tree.bvh().validate(), Sentences{});
      EXPECT_EQ(tree.bvh().report.update.hidden, tree.bvh().report.references);
      tree.rebuild(point);
      EXPECT_EQ(tree.bvh().report.references, 0u);
      tree.rebuild(mesh.vertices);
      EXPECT_TRUE(test::equal_bytes(tree.bvh(), build(mesh, recipe)));
    }
  }
}

TEST(UpdatableBvh, AnotherNumberOfVerticesIsAnErrorAndChangesNothing) {
  const test::OwnedMesh mesh = test::triangle_soup(100, 1);
  UpdatableBvh tree(mesh.view());
  const std::vector<Vec3> fewer(299);
  const std::string expected =
      "the tree was built over 300 vertices and cannot be updated with 299: an update moves "
      "vertices, it neither adds nor removes any";
  EXPECT_EQ(test::error_of([&] { tree.refit(fewer); }), expected);
  EXPECT_EQ(test::error_of([&] { tree.rebuild(fewer); }), expected);
  EXPECT_TRUE(test::equal_bytes(tree.bvh(), build(mesh.view())));
  EXPECT_EQ(tree.bvh().report.update.refits, 0u);
}

TEST(UpdatableBvh, KeepsItsOwnFacesAndMoves) {
  test::OwnedMesh mesh = test::triangle_soup(300, 1);
  UpdatableBvh built(mesh.view());
  const std::vector<Vec3> vertices = mesh.vertices;
  const Bvh expected = build(mesh.view());
  mesh = {};
  UpdatableBvh tree = std::move(built);
  tree.rebuild(vertices);
  tree.refit(vertices);
  EXPECT_TRUE(test::equal_bytes(tree.bvh(), expected));
}

std::size_t held_bytes(const UpdatableBvh& tree) { return tree.bvh().report.update.held_bytes; }

TEST(UpdatableBvh, MemoryStaysConstantOverRebuilds) {
  const test::OwnedMesh mesh = test::triangle_soup(5000, 6);
  for (const char* const recipe : {"balanced", "lbvh > treelet > bvh2", "sweep"}) {
    UpdatableBvh tree(mesh.view(), recipe);
    const std::size_t before_any = held_bytes(tree);
    EXPECT_LT(before_any, tree.bvh().report.tree.bytes * 9 / 8 + 12 * 5000 + 200);
    tree.refit(mesh.vertices);
    EXPECT_LT(held_bytes(tree), before_any + tree.bvh().report.tree.nodes + 200);
    std::vector<std::size_t> held;
    for (int number = 0; number < 50; ++number) {
      tree.rebuild(frame(mesh, number % 5).vertices);
      if (number % 3 == 0) tree.refit(frame(mesh, number % 7).vertices);
      held.push_back(held_bytes(tree));
    }
    const auto late = std::minmax_element(held.begin() + 10, held.end());
    EXPECT_LE(*late.second, *std::max_element(held.begin(), held.begin() + 10)) << recipe;
    EXPECT_LT(*late.second - *late.first, *late.first / 5) << recipe;
    EXPECT_LT(*late.second, 7 * before_any) << recipe;
  }
}

TEST(UpdatableBvh, ValidatesItsRebuildsWhereAsked) {
  const test::OwnedMesh mesh = test::triangle_soup(500, 6);
  UpdatableBvh tree(mesh.view(), "balanced", {.validate = true});
  EXPECT_NO_THROW(tree.rebuild(frame(mesh, 2).vertices));
}

TEST(UpdatableBvh, GivesTheSameBytesForAnyNumberOfThreads) {
  const test::OwnedMesh mesh = test::triangle_soup(20000, 9);
  const test::OwnedMesh moved = frame(mesh, 2);
  UpdatableBvh expected(mesh.view());
  expected.refit(moved.vertices);
  for (const unsigned threads : {1u, 2u, 7u}) {
    const test::ThreadCountScope scope(threads);
    UpdatableBvh tree(mesh.view());
    tree.rebuild(mesh.vertices);
    tree.refit(moved.vertices);
    EXPECT_TRUE(test::equal_bytes(tree.bvh(), expected.bvh())) << threads;
    EXPECT_EQ(tree.bvh().report.update.sah, expected.bvh().report.update.sah) << threads;
  }
}

}  // namespace
}  // namespace treelet
