#include <treelet/pipeline/split_trial.h>

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <string>
#include <variant>
#include <vector>

#include <treelet/query/brute_force.h>

#include "support/mesh_rays.h"
#include "support/meshes.h"
#include "support/threads.h"

namespace treelet {
namespace {

const std::string kRest = "lbvh > treelet(rounds=2, gamma=14) > bvh8";

/// A height field of cells x cells quads: boxes that their triangles fill well.
test::OwnedMesh hills(std::size_t cells) {
  test::OwnedMesh mesh = test::coplanar_grid(cells);
  for (Vec3& p : mesh.vertices) p.z = 0.05f * std::sin(9.0f * p.x) * std::cos(7.0f * p.y);
  return mesh;
}

void expect_same_bytes(const Bvh& a, const Bvh& b, const std::string& name) {
  const Bvh8 &first = std::get<Bvh8>(a.layout), &second = std::get<Bvh8>(b.layout);
  ASSERT_EQ(first.nodes.bytes(), second.nodes.bytes()) << name;
  ASSERT_EQ(first.blocks.bytes(), second.blocks.bytes()) << name;
  EXPECT_EQ(std::memcmp(first.nodes.data(), second.nodes.data(), first.nodes.bytes()), 0) << name;
  EXPECT_EQ(std::memcmp(first.blocks.data(), second.blocks.data(), first.blocks.bytes()), 0)
      << name;
}

TEST(SplitTrial, RefusesWhatHasNothingToGain) {
  const test::OwnedMesh mesh = hills(100);
  const Bvh bvh = build(mesh.view(), "trysplit > " + kRest);
  EXPECT_EQ(bvh.report.references, mesh.faces.size());
  expect_same_bytes(bvh, build(mesh.view(), kRest), "hills");
}

TEST(SplitTrial, SplitsSlivers) {
  const test::OwnedMesh mesh = test::slivers(5000, 1);
  const Bvh bvh = build(mesh.view(), "trysplit(budget=50) > " + kRest);
  EXPECT_GT(bvh.report.references, mesh.faces.size() * 14 / 10);
  expect_same_bytes(bvh, build(mesh.view(), "presplit(budget=50) > " + kRest), "slivers");
}

TEST(SplitTrial, PutsSpatialSplitsInTheBuildersPlace) {
  const test::OwnedMesh mesh = test::slivers(5000, 1);
  const std::string rest = " > treelet > bvh8";
  expect_same_bytes(build(mesh.view(), "trysbvh(budget=80) > lbvh" + rest),
                    build(mesh.view(), "sbvh(budget=80)" + rest), "kept");
  expect_same_bytes(build(mesh.view(), "trysbvh(margin=100) > lbvh" + rest),
                    build(mesh.view(), "lbvh" + rest), "refused");
}

TEST(SplitTrial, WantsTheMargin) {
  const test::OwnedMesh mesh = test::slivers(5000, 1);
  EXPECT_EQ(build(mesh.view(), "trysplit(margin=100) > " + kRest).report.references,
            mesh.faces.size());
  const test::OwnedMesh smooth = hills(100);  // a tree like the other gains nothing
  EXPECT_EQ(build(smooth.view(), "trysplit(budget=0, margin=0) > " + kRest).report.references,
            smooth.faces.size());
}

TEST(SplitTrial, SaysWhatItFound) {
  const Bvh kept = build(test::slivers(5000, 1).view(), "trysplit(budget=50) > " + kRest);
  EXPECT_EQ(kept.report.recipe,
            "trysplit(budget=50, margin=2) > lbvh > treelet(size=7, rounds=2, gamma=14) > "
            "bvh8(leaf=8)");
  const auto& stages = kept.report.stages;
  ASSERT_GT(stages.size(), 3u);
  EXPECT_EQ(stages.front().name, "try without splits");
  EXPECT_TRUE(stages.back().name.ends_with("with splits, kept")) << stages.back().name;
  double sum = 0.0;
  for (const StageTime& stage : stages) sum += stage.seconds;
  EXPECT_LE(sum, kept.report.seconds);

  const Bvh refused = build(hills(100).view(), "trysplit > " + kRest);
  EXPECT_EQ(refused.report.stages[refused.report.stages.size() - 2].name, "try with splits");
  EXPECT_TRUE(refused.report.stages.back().name.ends_with("with splits, refused"))
      << refused.report.stages.back().name;
}

TEST(SplitTrial, FindsWhatBruteForceFinds) {
  for (const test::NamedMesh& hard : test::hard_meshes()) {
    const Mesh mesh = hard.mesh.view();
    for (const std::string layout : {"bvh2", "bvh8", "cwbvh"}) {
      const std::string recipe = "trysplit(budget=100, margin=0) > lbvh > treelet > " + layout;
      const Bvh bvh = build(mesh, recipe, {.validate = true});
      for (const Ray& ray : test::rays_at(mesh, 8, 22)) {
        ASSERT_EQ(bvh.intersect(ray), intersect_brute_force(mesh, ray))
            << hard.name << ", " << recipe;
      }
    }
  }
}

TEST(SplitTrial, GivesTheSameBytesForAnyNumberOfThreads) {
  const std::string recipe = "trysplit > lbvh > treelet > bvh8";
  for (const test::OwnedMesh& mesh : {test::triangle_soup(20000, 5), hills(80)}) {
    const Bvh expected = build(mesh.view(), recipe);
    for (const unsigned threads : {1u, 2u, 3u, 7u}) {
      const test::ThreadCountScope scope(threads);
      const Bvh bvh = build(mesh.view(), recipe);
      expect_same_bytes(bvh, expected, std::to_string(threads) + " threads");
      EXPECT_EQ(bvh.report.stages.back().name, expected.report.stages.back().name);
    }
  }
}

}  // namespace
}  // namespace treelet
