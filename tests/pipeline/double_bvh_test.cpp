#include <treelet/pipeline/double_bvh.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include <treelet/pipeline/build.h>

#include "support/closed_meshes.h"
#include "support/errors.h"
#include "support/mesh_rays.h"
#include "support/meshes.h"

// Floats are doubles: on meshes and rays of floats the answers must be those of the float path,
// which has its own oracles, but for the rounding of t, u and v.

namespace treelet {
namespace {

DoubleVec3 to_double(Vec3 v) { return {v.x, v.y, v.z}; }

DoubleRay to_double(const Ray& ray) {
  return {to_double(ray.origin), to_double(ray.direction), ray.t_min, ray.t_max};
}

struct DoubledMesh {
  std::vector<DoubleVec3> vertices;
  std::vector<Face> faces;

  explicit DoubledMesh(const test::OwnedMesh& mesh) : faces(mesh.faces) {
    for (const Vec3 v : mesh.vertices) vertices.push_back(to_double(v));
  }
  DoubleMesh view() const { return {vertices, faces}; }
};

/// A ray that may hit anywhere on its line: limits in floats and in doubles may differ in what they
/// let through.
Ray unlimited(Ray ray) {
  ray.t_min = -std::numeric_limits<float>::infinity();
  ray.t_max = std::numeric_limits<float>::infinity();
  return ray;
}

std::vector<std::int32_t> sorted_faces(const auto& hits) {
  std::vector<std::int32_t> faces;
  for (const auto& hit : hits) faces.push_back(hit.face);
  std::sort(faces.begin(), faces.end());
  return faces;
}

void expect_same_answers(const test::NamedMesh& named) {
  const DoubledMesh doubled(named.mesh);
  const Bvh bvh = build(named.mesh.view());
  const DoubleBvh exact = build(doubled.view());
  EXPECT_EQ(exact.report.left_out_degenerate, bvh.report.left_out_degenerate);
  EXPECT_EQ(exact.report.left_out_non_finite, bvh.report.left_out_non_finite);
  for (const Ray& given : test::rays_at(named.mesh.view(), 20, 3)) {
    const Ray ray = unlimited(given);
    const std::vector<Hit> hits = bvh.intersect_all(ray);
    const std::vector<DoubleHit> found = exact.intersect_all(to_double(ray));
    EXPECT_EQ(sorted_faces(found), sorted_faces(hits)) << named.name;
    EXPECT_EQ(exact.count_hits(to_double(ray)), std::int64_t(hits.size()));
    const Hit closest = bvh.intersect(given);
    const DoubleHit double_closest = exact.intersect(to_double(given));
    EXPECT_EQ(double_closest.is_hit(), exact.is_occluded(to_double(given)));
    if (given.t_min != 0.0f || given.t_max < std::numeric_limits<float>::infinity()) continue;
    EXPECT_EQ(double_closest.is_hit(), closest.is_hit()) << named.name;
    if (!closest.is_hit()) continue;
    EXPECT_NEAR(double_closest.t, closest.t, 0x1p-22 * std::fabs(closest.t) + 0x1p-148)
        << named.name;
  }
}

TEST(DoubleBvh, AnswersAsInFloatsOnHardMeshes) {
  for (const test::NamedMesh& mesh : test::hard_meshes()) expect_same_answers(mesh);
}

TEST(DoubleBvh, AnswersAsInFloatsOnClosedMeshes) {
  for (const test::NamedMesh& mesh : test::closed_meshes()) expect_same_answers(mesh);
}

TEST(DoubleBvh, BatchesAnswerAsSingleRays) {
  const test::OwnedMesh mesh = test::icosphere(3);
  const DoubleBvh bvh = build(DoubledMesh(mesh).view());
  std::vector<DoubleRay> rays;
  for (const Ray& ray : test::rays_at(mesh.view(), 200, 4)) rays.push_back(to_double(ray));
  const std::vector<DoubleHit> hits = bvh.intersect(rays);
  const DoubleAllHits all = intersect_all(bvh.layout, DoubleRayBatch(rays));
  std::vector<std::int64_t> counts(rays.size());
  count_hits(bvh.layout, DoubleRayBatch(rays), counts);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    EXPECT_EQ(hits[i], bvh.intersect(rays[i]));
    const std::vector<DoubleHit> row = bvh.intersect_all(rays[i]);
    const auto begin = std::size_t(all.offsets[i]), end = std::size_t(all.offsets[i + 1]);
    ASSERT_EQ(row.size(), end - begin);
    EXPECT_EQ(counts[i], std::int64_t(row.size()));
    for (std::size_t k = begin; k < end; ++k) {
      const DoubleHit hit{all.t[k], all.u[k], all.v[k], all.face[k]};
      EXPECT_EQ(hit, row[k - begin]);
    }
  }
}

/// A node's child holds it: the box of a leaf its triangles, that of a node its children's boxes.
void expect_contained(const DoubleBvh8& bvh, const Bvh8Node& node) {
  for (int i = 0; i < Bvh8Node::kChildren && !node.child[i].is_none(); ++i) {
    const WideChild child = node.child[i];
    const Aabb box = node.box(i);
    if (!child.is_leaf()) {
      const Bvh8Node& below = bvh.nodes[child.node()];
      for (int k = 0; k < Bvh8Node::kChildren; ++k) EXPECT_TRUE(box.contains(below.box(k)));
      continue;
    }
    for (std::uint32_t block = 0; block < child.block_count(); ++block) {
      for (unsigned lane = 0; lane < DoubleBlock::kTriangles; ++lane) {
        const DoubleTriangle triangle = bvh.blocks[child.first_block() + block].triangle(lane);
        EXPECT_TRUE(box.contains(box_in_frame(triangle, bvh.frame)));
      }
    }
  }
}

TEST(DoubleBvh, BoxesContainWhatTheyHold) {
  for (const test::NamedMesh& named : test::hard_meshes()) {
    const DoubleBvh bvh = build(DoubledMesh(named.mesh).view(), "lbvh > bvh8", {.validate = true});
    for (const Bvh8Node& node : bvh.layout.nodes) expect_contained(bvh.layout, node);
  }
}

TEST(DoubleBvh, RefusesRecipesThatItCannotBuild) {
  const DoubledMesh mesh(test::two_triangles());
  for (const char* recipe : {"best", "presplit > lbvh", "sbvh > bvh8"}) {
    EXPECT_NE(test::error_of([&] { build(mesh.view(), recipe); }).find("split no triangles"),
              std::string::npos);
  }
  for (const char* recipe : {"lbvh > bvh2", "lbvh > cwbvh"}) {
    EXPECT_NE(test::error_of([&] { build(mesh.view(), recipe); }).find("of the layout bvh8"),
              std::string::npos);
  }
}

TEST(DoubleBvh, WantsRoomForAnswers) {
  const DoubleBvh bvh = build(DoubledMesh(test::one_triangle()).view());
  const std::vector<DoubleRay> rays(3);
  std::vector<std::int64_t> counts(2);
  EXPECT_EQ(test::error_of([&] { count_hits(bvh.layout, DoubleRayBatch(rays), counts); }),
            "there is room for 2 answers to 3 rays");
}

}  // namespace
}  // namespace treelet
