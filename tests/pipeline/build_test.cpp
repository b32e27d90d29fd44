#include <treelet/pipeline/build.h>

#include <gtest/gtest.h>

#include <treelet/layout/validate_layout.h>
#include <treelet/query/brute_force.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
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

std::vector<std::string> stage_names(const Bvh& bvh) {
  std::vector<std::string> names;
  for (const StageTime& stage : bvh.report.stages) names.emplace_back(stage.name);
  return names;
}

TEST(Build, ReportsCounts) {
  const test::OwnedMesh mesh = test::soup_with_bad_faces(600, 3);
  std::size_t kinds[3] = {};
  for (std::size_t i = 0; i < 600; ++i) ++kinds[int(classify(mesh.view().triangle(i)))];
  const Bvh bvh = build(mesh.view(), "lbvh > bvh2");
  EXPECT_EQ(bvh.report.recipe, "lbvh > bvh2(leaf=8)");
  EXPECT_EQ(bvh.report.faces, 600u);
  EXPECT_EQ(bvh.report.references, kinds[int(TriangleKind::regular)]);
  EXPECT_EQ(bvh.report.left_out_non_finite, kinds[int(TriangleKind::non_finite)]);
  EXPECT_EQ(bvh.report.left_out_degenerate, kinds[int(TriangleKind::degenerate)]);
  EXPECT_GT(bvh.report.left_out_non_finite, 0u);
  EXPECT_GT(bvh.report.left_out_degenerate, 0u);
}

TEST(Build, OfAnLbvhGivesTheSameBytesWithAndWithoutTheTreeBetween) {
  const test::OwnedMesh mesh = test::soup_with_bad_faces(20'000, 6);
  const Bvh quick = build(mesh.view(), "fast", {.validate = false});
  const Bvh checked = build(mesh.view(), "fast", {.validate = true});
  EXPECT_EQ(stage_names(quick).size() + 1, stage_names(checked).size());
  EXPECT_TRUE(test::equal_bytes(quick, checked));
  EXPECT_EQ(quick.report.sah, checked.report.sah);
}

TEST(Build, ReportsTheTree) {
  const test::OwnedMesh mesh = test::triangle_soup(1000, 4);
  const Bvh bvh = build(mesh.view(), "lbvh > bvh2(leaf=4)");
  const TreeStatistics& tree = bvh.report.tree;
  EXPECT_EQ(bvh.sah.leaf_limit, 4u);
  EXPECT_EQ(tree.nodes, std::get<Bvh2>(bvh.layout).nodes.size());
  EXPECT_EQ(tree.leaves, tree.nodes + 1);
  EXPECT_EQ(tree.triangles, 1000u);
  EXPECT_EQ(tree.bytes, tree.nodes * 64 + 1000 * 40);
  EXPECT_LE(tree.leaf_histogram.size(), 5u);
  std::size_t triangles = 0;
  for (std::size_t size = 0; size < tree.leaf_histogram.size(); ++size) {
    triangles += size * tree.leaf_histogram[size];
  }
  EXPECT_EQ(triangles, 1000u);
  EXPECT_NEAR(tree.sah, bvh.report.sah, 1e-5 * tree.sah);
  EXPECT_GT(tree.sah, 1.0);
}

TEST(Build, ReportsItsStages) {
  const test::OwnedMesh mesh = test::triangle_soup(5000, 4);
  const Bvh fast = build(mesh.view(), "lbvh > bvh2");
  EXPECT_EQ(stage_names(fast),
            (Sentences{"create references", "compute Morton codes", "sort Morton codes",
                       "emit hierarchy", "collapse leaves", "pack bvh2"}));
  double in_stages = 0.0;
  for (const StageTime& stage : fast.report.stages) {
    EXPECT_GT(stage.seconds, 0.0) << stage.name;
    in_stages += stage.seconds;
  }
  EXPECT_GE(fast.report.seconds, in_stages);
  const Sentences balanced = stage_names(build(mesh.view(), "balanced"));
  EXPECT_EQ(std::count(balanced.begin(), balanced.end(), "restructure treelets"), 1);
}

TEST(Build, OptimizersLowerTheCost) {
  const test::OwnedMesh mesh = test::triangle_soup(3000, 4);
  const double fast = build(mesh.view(), "lbvh").report.sah;
  EXPECT_LT(build(mesh.view(), "lbvh > treelet").report.sah, 0.97 * fast);
  EXPECT_LT(build(mesh.view(), "sweep").report.sah, 0.97 * fast);
}

TEST(Build, TheDefaultIsBalanced) {
  const test::OwnedMesh mesh = test::triangle_soup(300, 4);
  EXPECT_TRUE(test::equal_bytes(build(mesh.view()), build(mesh.view(), "balanced")));
}

TEST(Build, EveryStageIsSoundOnEveryMesh) {
  for (const test::NamedMesh& named : test::hard_meshes()) {
    for (const std::string& recipe : test::every_recipe()) {
      SCOPED_TRACE(named.name + ", " + recipe);
      Bvh bvh;
      ASSERT_NO_THROW(bvh = build(named.mesh.view(), recipe, {.validate = true}));
      EXPECT_EQ(bvh.validate(named.mesh.view()), Sentences{});
      EXPECT_TRUE(std::isfinite(bvh.report.tree.sah));
    }
  }
}

TEST(Build, GivesTheSameBytesForAnyNumberOfThreads) {
  const test::OwnedMesh mesh = test::triangle_soup(20000, 9);
  for (const char* const recipe :
       {"lbvh > bvh2", "lbvh > treelet > bvh8", "sweep > treelet > bvh2"}) {
    Bvh expected;
    for (const unsigned threads : {1u, 2u, 3u, 7u}) {
      const test::ThreadCountScope scope(threads);
      Bvh bvh = build(mesh.view(), recipe);
      if (threads == 1)
        expected = std::move(bvh);
      else
        EXPECT_TRUE(test::equal_bytes(bvh, expected)) << recipe << ", " << threads;
    }
  }
}

TEST(Build, NamesTheFirstBadIndex) {
  test::OwnedMesh mesh = test::triangle_soup(50, 1);
  mesh.faces[30] = {0, 1, 150};
  mesh.faces[20] = {3, 4294967295, 5};
  const auto error = [](const Mesh& view) { return test::error_of([&] { build(view); }); };
  EXPECT_EQ(error(mesh.view()),
            "face 20 refers to vertex 4294967295, but the mesh has vertices 0 to 149");
  mesh.vertices.clear();
  EXPECT_EQ(error(mesh.view()), "face 0 refers to vertex 0, but the mesh has no vertices");
}

TEST(Build, NamesTheBadRecipe) {
  const std::string error = test::error_of([] { build(Mesh{}, "lbvh > "); });
  EXPECT_EQ(error, "recipe \"lbvh > \": expected the name of a stage at character 8");
}

class Metamorphic : public testing::TestWithParam<const char*> {
 protected:
  const test::OwnedMesh mesh_ = test::triangle_soup(800, 12);
  const std::vector<Ray> rays_ = test::rays_at(mesh_.view(), 200, 13);
  std::vector<Hit> trace(const test::OwnedMesh& mesh, std::span<const Ray> rays) const {
    return build(mesh.view(), GetParam()).intersect(rays);
  }
  const std::vector<Hit> hits_ = trace(mesh_, rays_);
};

TEST_P(Metamorphic, ScalingByAPowerOfTwoScalesT) {
  for (const int exponent : {-90, -10, 1, 17, 80}) {
    const float factor = std::ldexp(1.0f, exponent);
    std::vector<Ray> rays = rays_;
    for (Ray& ray : rays) {
      ray.origin = ray.origin * factor;
      ray.t_min *= factor;
      ray.t_max *= factor;
    }
    const test::OwnedMesh mesh = test::scaled(mesh_, factor);
    const std::vector<Hit> hits = trace(mesh, rays);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      ASSERT_EQ(hits[i].face, hits_[i].face) << "2^" << exponent << ", ray " << i;
      ASSERT_EQ(hits[i].t, hits_[i].t * factor) << "2^" << exponent << ", ray " << i;
      ASSERT_EQ(hits[i].u, hits_[i].u) << "2^" << exponent << ", ray " << i;
      ASSERT_EQ(hits[i].v, hits_[i].v) << "2^" << exponent << ", ray " << i;
    }
  }
}

TEST_P(Metamorphic, TheOrderOfTrianglesChangesNoT) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const test::OwnedMesh mesh = test::permuted(mesh_, seed);
    const std::vector<Hit> hits = trace(mesh, rays_);
    for (std::size_t i = 0; i < rays_.size(); ++i) {
      ASSERT_EQ(hits[i].t, hits_[i].t) << "seed " << seed << ", ray " << i;
    }
  }
}

TEST_P(Metamorphic, AMirrorChangesNoT) {
  const auto mirror = [](Vec3 p, int axis) {
    return Vec3{axis == 0 ? -p.x : p.x, axis == 1 ? -p.y : p.y, axis == 2 ? -p.z : p.z};
  };
  for (int axis = 0; axis < 3; ++axis) {
    test::OwnedMesh mesh = mesh_;
    for (Vec3& vertex : mesh.vertices) vertex = mirror(vertex, axis);
    std::vector<Ray> rays = rays_;
    for (Ray& ray : rays) {
      ray.origin = mirror(ray.origin, axis);
      ray.direction = mirror(ray.direction, axis);
    }
    const std::vector<Hit> hits = trace(mesh, rays);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      ASSERT_EQ(hits[i], hits_[i]) << "axis " << axis << ", ray " << i;
    }
  }
}

TEST_P(Metamorphic, SomeRaysHit) {
  std::size_t hits = 0;
  for (const Hit& hit : hits_) hits += hit.is_hit();
  EXPECT_GT(hits, rays_.size() / 3);
  EXPECT_LT(hits, rays_.size());
}

INSTANTIATE_TEST_SUITE_P(Layouts, Metamorphic,
                         testing::Values("lbvh > treelet > bvh2", "lbvh > treelet > bvh8"),
                         [](const auto& test) { return std::string(test.param).substr(17); });

TEST(Build, SlowAMillionEqualMortonCodes) {
  const test::OwnedMesh mesh = test::equal_centres(1000000);
  const Bvh bvh = build(mesh.view(), "balanced", {.validate = true});
  EXPECT_LT(bvh.report.tree.depth, 100u);
  for (const Ray& ray : test::rays_at(mesh.view(), 3, 1)) {
    EXPECT_EQ(bvh.intersect(ray), intersect_brute_force(mesh.view(), ray)) << "seed 1";
  }
}

}  // namespace
}  // namespace treelet
