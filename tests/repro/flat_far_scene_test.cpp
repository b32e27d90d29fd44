#include <gtest/gtest.h>

#include <treelet/pipeline/build.h>
#include <treelet/primitive/reference.h>
#include <treelet/query/brute_force.h>

#include "support/mesh_rays.h"
#include "support/meshes.h"

namespace treelet {
namespace {

/// Triangles of size 1e-10 in the plane y = 1e30.
test::OwnedMesh tiny_mesh_in_a_far_plane() {
  test::OwnedMesh mesh = test::scaled(test::triangle_soup(300, 261), 1e-10f);
  for (Vec3& vertex : mesh.vertices) vertex.y = 1e30f;
  return mesh;
}

// In a space scaled to the mesh's size the plane was at infinity: extents and areas became NaN.
TEST(Repro, FlatSceneVeryFarFromTheOrigin) {
  const test::OwnedMesh mesh = tiny_mesh_in_a_far_plane();
  const References references = create_references(mesh.view());
  ASSERT_EQ(references.size(), 300u);
  EXPECT_EQ(references.bounds.extent().y, 0.0f);
  EXPECT_GE(max_component(references.bounds.extent()), 0.5f);
  for (const char* const recipe : {"lbvh > treelet > bvh2", "lbvh > treelet > bvh8"}) {
    const Bvh bvh = build(mesh.view(), recipe);
    for (const Ray& ray : test::rays_at(mesh.view(), 100, 262)) {
      ASSERT_EQ(bvh.intersect(ray), intersect_brute_force(mesh.view(), ray)) << recipe;
    }
  }
}

}  // namespace
}  // namespace treelet
