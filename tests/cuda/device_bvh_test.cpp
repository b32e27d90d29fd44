#include <treelet/pipeline/device_bvh.h>

#include <gtest/gtest.h>

#include <treelet/core/cuda_error.h>
#include <treelet/pipeline/build.h>

#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "cuda/device_input.h"
#include "cuda/schedules.h"
#include "support/errors.h"
#include "support/layouts.h"
#include "support/mesh_params.h"
#include "support/mesh_rays.h"
#include "support/meshes.h"

namespace treelet {
namespace {

/// Recipes whose every word runs on the device.
const std::vector<std::string> kRecipes{"lbvh > bvh2",
                                        "lbvh > treelet > bvh2",
                                        "lbvh > treelet(size=5, rounds=2) > bvh8(leaf=4)",
                                        "lbvh > treelet > bvh8",
                                        "hploc > treelet > bvh2",
                                        "presplit(budget=20) > lbvh > treelet > bvh8",
                                        "presplit(budget=50) > hploc > bvh2",
                                        "lbvh > treelet > cwbvh",
                                        "presplit(budget=30) > hploc > cwbvh(leaf=2)"};

/// A mesh's arrays in device memory.
class DeviceMeshArrays {
 public:
  explicit DeviceMeshArrays(const test::OwnedMesh& mesh)
      : vertices_(test::upload_all(std::span(mesh.vertices))),
        faces_(test::upload_all(std::span(mesh.faces))) {}

  cuda::DeviceMesh view() const {
    return {vertices_.data(), faces_.data(), std::uint32_t(vertices_.size()),
            std::uint32_t(faces_.size())};
  }

 private:
  cuda::DeviceArray<Vec3> vertices_;
  cuda::DeviceArray<Face> faces_;
};

cuda::DeviceBvh build_on_device(const test::OwnedMesh& mesh, const std::string& recipe,
                                const cuda::DeviceBuildOptions& options = {}) {
  return cuda::DeviceBvh::build(DeviceMeshArrays(mesh).view(), parse_recipe(recipe), options,
                                test::kStream);
}

class DeviceBvhTest : public testing::TestWithParam<test::NamedMesh> {};

TEST_P(DeviceBvhTest, IsTheHostsTreeToTheByte) {
  for (std::size_t i = 0; i < kRecipes.size(); ++i) {
    const Bvh host = build(GetParam().mesh.view(), kRecipes[i]);
    test::with_schedule(i % 4, [&] {
      const cuda::DeviceBvh device =
          build_on_device(GetParam().mesh, kRecipes[i], {.validate = true, .updatable = false});
      EXPECT_TRUE(test::equal_bytes(device.download(test::kStream), host)) << kRecipes[i];
    });
  }
}

TEST_P(DeviceBvhTest, ReportsWhatTheHostReports) {
  for (const std::string& recipe : kRecipes) {
    const BuildReport host = build(GetParam().mesh.view(), recipe).report;
    const cuda::DeviceBvh bvh = build_on_device(GetParam().mesh, recipe);
    const BuildReport& device = bvh.report();
    EXPECT_EQ(device.recipe, host.recipe);
    EXPECT_EQ(device.faces, host.faces);
    EXPECT_EQ(device.references, host.references);
    EXPECT_EQ(device.left_out_non_finite, host.left_out_non_finite);
    EXPECT_EQ(device.left_out_degenerate, host.left_out_degenerate);
    EXPECT_EQ(device.sah, host.sah) << recipe;
    EXPECT_EQ(device.tree.nodes, host.tree.nodes);
    EXPECT_EQ(device.tree.depth, host.tree.depth);
    EXPECT_EQ(device.tree.bytes, host.tree.bytes);
    EXPECT_GE(device.stages.size(), 5u);
  }
}

TEST_P(DeviceBvhTest, AnswersLikeTheHost) {
  const test::OwnedMesh& mesh = GetParam().mesh;
  const std::vector<Ray> rays = test::rays_at(mesh.view(), 40, 11);
  if (rays.empty()) return;
  const cuda::DeviceArray<Ray> device_rays = test::upload_all(std::span(rays));
  cuda::DeviceRayBatch batch;
  batch.size = rays.size();
  const auto* first = device_rays.data();
  batch.origins = {&first->origin, sizeof(Ray)};
  batch.directions = {&first->direction, sizeof(Ray)};
  batch.t_min = {&first->t_min, sizeof(Ray)};
  batch.t_max = {&first->t_max, sizeof(Ray)};
  for (const std::string& recipe : kRecipes) {
    const Bvh host = build(mesh.view(), recipe);
    const cuda::DeviceBvh bvh = build_on_device(mesh, recipe);
    cuda::DeviceArray<float> t(rays.size(), test::kStream), u(rays.size(), test::kStream),
        v(rays.size(), test::kStream);
    cuda::DeviceArray<std::int32_t> face(rays.size(), test::kStream);
    cuda::DeviceArray<bool> occluded(rays.size(), test::kStream);
    bvh.intersect(batch, {t.data(), face.data(), u.data(), v.data()}, test::kStream);
    bvh.find_occluded(batch, occluded.data(), test::kStream);
    const auto ts = cuda::download(t), us = cuda::download(u), vs = cuda::download(v);
    const auto faces = cuda::download(face);
    const auto any = cuda::download(occluded);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const Hit expected = host.intersect(rays[i]);
      ASSERT_EQ((Hit{ts[i], faces[i], us[i], vs[i]}), expected) << recipe << ", ray " << i;
      ASSERT_EQ(any[i], expected.is_hit()) << recipe << ", ray " << i;
    }
  }
}

/// Few enough triangles for every sanitizer; each stage has hard meshes in its own tests.
std::vector<test::NamedMesh> small_meshes() {
  std::vector<test::NamedMesh> meshes = test::hard_meshes();
  std::erase_if(meshes, [](const test::NamedMesh& named) { return named.mesh.faces.size() > 100; });
  meshes.push_back({"SoupOf150Seed6", test::triangle_soup(150, 6)});
  meshes.push_back({"BadFacesOf150Seed7", test::soup_with_bad_faces(150, 7)});
  return meshes;
}

INSTANTIATE_TEST_SUITE_P(Meshes, DeviceBvhTest, testing::ValuesIn(small_meshes()), test::mesh_name);
INSTANTIATE_TEST_SUITE_P(SlowMeshes, DeviceBvhTest, testing::ValuesIn(test::device_meshes()),
                         test::mesh_name);

TEST(DeviceBvh, MovesToTheDeviceAndBack) {
  const test::OwnedMesh mesh = test::triangle_soup(3000, 5);
  for (const char* recipe : {"sweep > bvh2", "hploc > treelet > bvh8", "sweep > cwbvh"}) {
    const Bvh host = build(mesh.view(), recipe);
    const cuda::DeviceBvh device = cuda::DeviceBvh::upload(host, test::kStream);
    const Bvh back = device.download(test::kStream);
    EXPECT_TRUE(test::equal_bytes(back, host));
    EXPECT_EQ(back.report.recipe, host.report.recipe);
    EXPECT_EQ(device.bounds(), host.bounds());
  }
}

TEST(DeviceBvh, NamesTheFirstBadFace) {
  test::OwnedMesh mesh = test::triangle_soup(1000, 5);
  mesh.faces[700][1] = std::uint32_t(mesh.vertices.size());
  mesh.faces[900][0] = 0xffffffff;
  const auto on_host = [&] { build(mesh.view(), "lbvh > bvh2"); };
  const auto on_device = [&] { build_on_device(mesh, "lbvh > bvh2"); };
  EXPECT_EQ(test::error_of(on_device), test::error_of(on_host));
}

TEST(DeviceBvh, SaysWhichWordsRunOnTheHostAlone) {
  const auto build = [] { build_on_device(test::one_triangle(), "sweep > bvh2"); };
  const std::string text = test::error_of<cuda::CudaError>(build);
  EXPECT_NE(text.find("'sweep' runs on the CPU alone"), std::string::npos) << text;
}

/// The mesh with every vertex moved by a wave.
test::OwnedMesh waved(test::OwnedMesh mesh, float phase) {
  for (Vec3& p : mesh.vertices) p.z += 0.3f * std::sin(5.0f * p.x + phase);
  return mesh;
}

class DeviceUpdateTest : public testing::TestWithParam<std::string> {};

TEST_P(DeviceUpdateTest, RebuildsTheTreeThatABuildGives) {
  const test::OwnedMesh mesh = test::triangle_soup(6000, 9);
  cuda::DeviceBvh bvh = build_on_device(mesh, GetParam(), {.validate = false, .updatable = true});
  for (const float phase : {0.5f, 2.0f}) {
    const test::OwnedMesh moved = waved(mesh, phase);
    const auto vertices = test::upload_all(std::span(moved.vertices));
    bvh.rebuild(vertices.data(), std::uint32_t(vertices.size()), test::kStream);
    bvh.check(test::kStream);
    const Bvh host = build(moved.view(), GetParam());
    EXPECT_TRUE(test::equal_bytes(bvh.download(test::kStream), host));
    EXPECT_EQ(bvh.report().sah, host.report.sah);
  }
}

TEST_P(DeviceUpdateTest, RefitsToMovedVertices) {
  const test::OwnedMesh mesh = test::triangle_soup(2000, 9);
  const test::OwnedMesh moved = waved(mesh, 1.0f);
  cuda::DeviceBvh bvh = build_on_device(mesh, GetParam(), {.validate = false, .updatable = true});
  const auto vertices = test::upload_all(std::span(moved.vertices));
  bvh.refit(vertices.data(), std::uint32_t(vertices.size()), test::kStream);
  const Bvh refitted = bvh.download(test::kStream);
  EXPECT_EQ(refitted.validate(moved.view()), std::vector<std::string>{});
}

TEST_P(DeviceUpdateTest, SaysWhenARebuildDoesNotFit) {
  test::OwnedMesh flat = test::triangle_soup(3000, 9);
  const test::OwnedMesh full = flat;
  for (Vec3& p : flat.vertices) p = {0.25f, 0.5f, 0.75f};  // nothing is left of it
  cuda::DeviceBvh bvh = build_on_device(flat, GetParam(), {.validate = false, .updatable = true});
  const auto vertices = test::upload_all(std::span(full.vertices));
  bvh.rebuild(vertices.data(), std::uint32_t(vertices.size()), test::kStream);
  EXPECT_THROW(bvh.check(test::kStream), cuda::CudaError);
  bvh.rebuild(vertices.data(), std::uint32_t(vertices.size()), test::kStream);
  bvh.check(test::kStream);
  EXPECT_TRUE(test::equal_bytes(bvh.download(test::kStream), build(full.view(), GetParam())));
}

/// Names a test after the last word of its recipe.
std::string layout_name(const testing::TestParamInfo<std::string>& parameter) {
  return parameter.param.substr(parameter.param.rfind(' ') + 1);
}

INSTANTIATE_TEST_SUITE_P(Recipes, DeviceUpdateTest,
                         testing::Values("lbvh > treelet > bvh2", "lbvh > bvh8", "hploc > cwbvh"),
                         layout_name);

TEST(DeviceBvh, UpdatesOnlyWhatIsUpdatable) {
  const test::OwnedMesh mesh = test::triangle_soup(100, 9);
  const auto vertices = test::upload_all(std::span(mesh.vertices));
  const auto count = std::uint32_t(vertices.size());
  cuda::DeviceBvh fixed = build_on_device(mesh, "lbvh > bvh2");
  EXPECT_THROW(fixed.refit(vertices.data(), count, test::kStream), std::logic_error);
  cuda::DeviceBvh moving =
      build_on_device(mesh, "lbvh > bvh2", {.validate = false, .updatable = true});
  EXPECT_THROW(moving.rebuild(vertices.data(), count - 1, test::kStream), std::invalid_argument);
}

}  // namespace
}  // namespace treelet
