#include <gtest/gtest.h>

#include <treelet/pipeline/build.h>
#include <treelet/query/brute_force.h>

#include <string>

#include "support/mesh_rays.h"
#include "support/meshes.h"

namespace treelet {
namespace {

// In a scene of size 1e-38 the padding of boxes underflowed to nothing, and hits were lost.
TEST(Repro, SceneOfDenormalSize) {
  const test::OwnedMesh mesh = test::scaled(test::triangle_soup(300, 4), 1e-38f);
  for (const char* const recipe : {"lbvh > bvh2", "lbvh > bvh8"}) {
    const Bvh bvh = build(mesh.view(), recipe);
    for (const Ray& ray : test::rays_at(mesh.view(), 100, 5)) {
      ASSERT_EQ(bvh.intersect(ray), intersect_brute_force(mesh.view(), ray)) << recipe;
    }
  }
}

}  // namespace
}  // namespace treelet
