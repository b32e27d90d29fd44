#include <treelet/pipeline/build.h>

#include <gtest/gtest.h>

#include <treelet/primitive/split.h>
#include <treelet/query/brute_force.h>

#include <cmath>
#include <cstring>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "support/mesh_params.h"
#include "support/mesh_rays.h"
#include "support/meshes.h"
#include "support/random.h"
#include "support/threads.h"

// Split triangles from end to end: hits are those of the whole ones.

namespace treelet {
namespace {

const std::vector<std::string> kLayouts{
    "bvh2", "bvh2(leaf=1)", "bvh8", "bvh8(leaf=1)", "bvh8(leaf=16)", "cwbvh", "cwbvh(leaf=1)"};

void expect_hits(const Bvh& bvh, const Mesh& mesh, const std::vector<Ray>& rays,
                 const std::string& name) {
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Hit expected = intersect_brute_force(mesh, rays[i]);
    ASSERT_EQ(bvh.intersect(rays[i]), expected) << name << ", ray " << i;
    ASSERT_EQ(bvh.is_occluded(rays[i]), expected.is_hit()) << name << ", ray " << i;
  }
}

class Presplit : public testing::TestWithParam<test::NamedMesh> {
 protected:
  const test::OwnedMesh& mesh_ = GetParam().mesh;
};

TEST_P(Presplit, FindsWhatBruteForceFinds) {
  for (const int budget : {1, 10, 100, 300}) {
    for (const std::string& layout : kLayouts) {
      const std::string recipe =
          "presplit(budget=" + std::to_string(budget) + ") > lbvh > treelet > " + layout;
      const Bvh bvh = build(mesh_.view(), recipe, {.validate = true});
      expect_hits(bvh, mesh_.view(), test::rays_at(mesh_.view(), 12, 21), recipe + ", seed 21");
    }
  }
}

INSTANTIATE_TEST_SUITE_P(HardMeshes, Presplit, testing::ValuesIn(test::hard_meshes()),
                         test::mesh_name);

/// Rays at points of triangles on the very planes at which they were split, and along these planes.
std::vector<Ray> rays_at_split_planes(const Mesh& mesh, std::size_t budget, std::uint64_t seed) {
  test::Random random(seed);
  References references = create_references(mesh);
  split_references(references, mesh, budget);
  const float scale = std::ldexp(1.0f, references.scale_exponent);
  std::vector<Ray> rays;
  for (const Reference& item : references.items) {
    const Triangle t = mesh.triangle(item.face);
    const int axis = int(random.below(3));
    const float plane = scale * (random.below(2) ? item.lower : item.upper)[axis];
    const Vec3 a = t.p0, b = t.p1;
    if (!((a[axis] < plane) != (b[axis] < plane)) || a[axis] == b[axis]) continue;
    Vec3 target = a + (b - a) * ((plane - a[axis]) / (b[axis] - a[axis]));
    (axis == 0 ? target.x : axis == 1 ? target.y : target.z) = plane;
    target = target + (t.p2 - target) * (random.below(2) ? 0.0f : random.uniform(0.0f, 1e-6f));
    Ray ray;
    ray.origin = random.point(-1.0f, 2.0f) * scale;
    if (random.below(2))
      (axis == 0 ? ray.origin.x : axis == 1 ? ray.origin.y : ray.origin.z) = plane;
    ray.direction = target - ray.origin;
    if (!(ray.direction == Vec3{0, 0, 0})) rays.push_back(ray);
  }
  return rays;
}

TEST(PresplitPlanes, LoseNoRay) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    for (const test::OwnedMesh& mesh :
         {test::triangle_soup(150, seed), test::slivers(150, seed), test::coplanar_grid(6),
          test::scaled(test::triangle_soup(100, seed), 1e-30f),
          test::translated(test::triangle_soup(100, seed), {100, -50, 7})}) {
      const std::size_t faces = mesh.faces.size();
      const std::vector<Ray> rays = rays_at_split_planes(mesh.view(), 3 * faces, seed);
      for (const std::string& layout : kLayouts) {
        const Bvh bvh = build(mesh.view(), "presplit(budget=300) > lbvh > " + layout);
        expect_hits(bvh, mesh.view(), rays, layout + ", seed " + std::to_string(seed));
      }
    }
  }
}

TEST(PresplitPlanes, LeaveAClosedMeshWatertight) {
  const test::OwnedMesh mesh = test::icosphere(3);
  for (const std::string& layout : kLayouts) {
    const Bvh bvh = build(mesh.view(), "presplit(budget=300) > lbvh > treelet > " + layout);
    ASSERT_GT(bvh.report.references, 3 * mesh.faces.size());
    std::vector<Ray> rays = rays_at_split_planes(mesh.view(), 3 * mesh.faces.size(), 31);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      rays[i].origin = {0.1f, -0.05f,
                        0.02f};  // from inside, so that each ray leaves through a face
      ASSERT_TRUE(bvh.intersect(rays[i]).is_hit()) << layout << ", seed 31, ray " << i;
    }
    expect_hits(bvh, mesh.view(), test::rays_at(mesh.view(), 100, 32), layout + ", seed 32");
  }
}

TEST(PresplitBuild, ReportsReferencesAndTriangles) {
  const test::OwnedMesh mesh = test::slivers(1000, 1);
  const Bvh bvh = build(mesh.view(), "presplit(budget=50) > lbvh > bvh2(leaf=1)");
  EXPECT_GT(bvh.report.references, 1480u);
  EXPECT_LE(bvh.report.references, 1500u);
  EXPECT_EQ(bvh.report.tree.triangles, std::get<Bvh2>(bvh.layout).triangles.size());
  EXPECT_NEAR(bvh.report.sah, bvh.report.tree.sah, 1e-4 * bvh.report.sah);
  EXPECT_EQ(bvh.report.recipe, "presplit(budget=50) > lbvh > bvh2(leaf=1)");
  EXPECT_EQ(bvh.report.stages[1].name, std::string("split triangles"));
}

TEST(PresplitBuild, GainsOnSliversWithTheBudget) {
  const test::OwnedMesh mesh = test::slivers(2000, 2);
  const double whole = build(mesh.view(), "lbvh > treelet > bvh2").report.tree.sah;
  double before = whole;
  for (const int budget : {30, 100, 300}) {
    const std::string recipe =
        "presplit(budget=" + std::to_string(budget) + ") > lbvh > treelet > bvh2";
    const double split = build(mesh.view(), recipe).report.tree.sah;
    EXPECT_LT(split, before) << recipe;
    before = split;
  }
  EXPECT_LT(before, 0.6 * whole);
}

template <class Layout>
double leaf_area(const Layout& bvh) {
  double sum = 0.0;
  for (const Bvh2Node& node : bvh.nodes) {
    for (const int child : {0, 1})
      sum += node.is_leaf(child) ? half_area_double(node.box[child]) : 0;
  }
  return sum;
}

TEST(PresplitBuild, LeavesHaveTheBoxesOfPieces) {
  const test::OwnedMesh mesh = test::slivers(500, 3);
  const Bvh whole = build(mesh.view(), "lbvh > bvh2(leaf=1)");
  const Bvh split = build(mesh.view(), "presplit(budget=300) > lbvh > bvh2(leaf=1)");
  EXPECT_LT(leaf_area(std::get<Bvh2>(split.layout)), 0.4 * leaf_area(std::get<Bvh2>(whole.layout)));
}

TEST(PresplitBuild, OfNothingGivesTheBytesOfTheUnsplitBuild) {
  const test::OwnedMesh mesh = test::triangle_soup(3000, 4);
  const Bvh plain = build(mesh.view(), "lbvh > treelet > bvh8");
  const Bvh split = build(mesh.view(), "presplit(budget=0) > lbvh > treelet > bvh8");
  const Bvh8 &a = std::get<Bvh8>(plain.layout), &b = std::get<Bvh8>(split.layout);
  ASSERT_EQ(a.nodes.size(), b.nodes.size());
  ASSERT_EQ(a.blocks.size(), b.blocks.size());
  EXPECT_EQ(std::memcmp(a.nodes.data(), b.nodes.data(), a.nodes.bytes()), 0);
  EXPECT_EQ(std::memcmp(a.blocks.data(), b.blocks.data(), a.blocks.bytes()), 0);
}

TEST(PresplitBuild, GivesTheSameBytesForAnyNumberOfThreads) {
  const test::OwnedMesh mesh = test::triangle_soup(20000, 5);
  const std::string recipe = "presplit(budget=60) > lbvh > treelet > bvh8";
  const Bvh expected = build(mesh.view(), recipe);
  for (const unsigned threads : {1u, 2u, 3u, 7u}) {
    const test::ThreadCountScope scope(threads);
    const Bvh bvh = build(mesh.view(), recipe);
    const Bvh8 &a = std::get<Bvh8>(bvh.layout), &b = std::get<Bvh8>(expected.layout);
    ASSERT_EQ(a.nodes.bytes(), b.nodes.bytes()) << threads;
    ASSERT_EQ(a.blocks.bytes(), b.blocks.bytes()) << threads;
    EXPECT_EQ(std::memcmp(a.nodes.data(), b.nodes.data(), a.nodes.bytes()), 0) << threads;
    EXPECT_EQ(std::memcmp(a.blocks.data(), b.blocks.data(), a.blocks.bytes()), 0) << threads;
  }
}

TEST(PresplitBuild, AGapBetweenPiecesIsFound) {
  const test::OwnedMesh mesh = test::slivers(100, 6);
  Bvh bvh = build(mesh.view(), "presplit(budget=300) > lbvh > bvh2(leaf=1)");
  ASSERT_EQ(bvh.validate(mesh.view()), std::vector<std::string>{});
  Bvh2& layout = std::get<Bvh2>(bvh.layout);
  std::size_t broken = 0;
  for (Bvh2Node& node : layout.nodes) {
    if (!node.is_leaf(0)) continue;
    const float before = node.box[0].lower.x;
    node.box[0].lower.x += 0.25f * (node.box[0].upper.x - before);
    broken += !bvh.validate(mesh.view()).empty();
    node.box[0].lower.x = before;
    if (broken > 20) break;
  }
  EXPECT_GT(broken, 20u);
}

}  // namespace
}  // namespace treelet
