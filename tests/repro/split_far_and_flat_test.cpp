// Splitting lost hits on meshes whose coordinates build space had to round: those beyond its limit,
// and those of axes far smaller than the others. Pieces did not cover their triangles there.

#include <gtest/gtest.h>

#include <treelet/pipeline/build.h>
#include <treelet/query/brute_force.h>

#include <string>
#include <vector>

#include "support/mesh_rays.h"
#include "support/meshes.h"

namespace treelet {
namespace {

test::OwnedMesh stretched(Vec3 factor, Vec3 offset) {
  test::OwnedMesh mesh = test::triangle_soup(300, 8);
  for (Vec3& p : mesh.vertices) {
    p = {p.x * factor.x + offset.x, p.y * factor.y + offset.y, p.z * factor.z + offset.z};
  }
  return mesh;
}

std::vector<test::OwnedMesh> far_and_flat_meshes() {
  std::vector<test::OwnedMesh> meshes;
  for (const Vec3 factor : {Vec3{1, 1, 1e-39f},
                            {1, 1e-38f, 1e-38f},
                            {1e30f, 1, 1e-30f},
                            {1e20f, 1, 1e-20f},
                            {1e35f, 1, 1e35f}}) {
    meshes.push_back(stretched(factor, {0, 0, 0}));
  }
  meshes.push_back(stretched({0, 1e-3f, 1e-3f}, {1e38f, 0, 0}));
  meshes.push_back(stretched({0, 1e-9f, 1e-9f}, {-1e30f, 0, 0}));
  return meshes;
}

TEST(SplitFarAndFlat, PiecesCoverTheirTrianglesAndNoHitIsLost) {
  for (const test::OwnedMesh& mesh : far_and_flat_meshes()) {
    const std::vector<Ray> rays = test::rays_at(mesh.view(), 40, 3);
    for (const char* const recipe :
         {"presplit(budget=100) > lbvh > bvh8", "presplit(budget=100) > lbvh > bvh2",
          "presplit(budget=100) > lbvh > cwbvh", "sbvh > bvh8", "sbvh > cwbvh", "best"}) {
      SCOPED_TRACE(std::string(recipe) + ", vertex " + std::to_string(mesh.vertices[0].x) + " " +
                   std::to_string(mesh.vertices[0].y) + " " + std::to_string(mesh.vertices[0].z));
      const Bvh bvh = build(mesh.view(), recipe, {.validate = true});
      for (const Ray& ray : rays) {
        ASSERT_EQ(bvh.intersect(ray), intersect_brute_force(mesh.view(), ray));
      }
    }
  }
}

}  // namespace
}  // namespace treelet
