#include <treelet/primitive/device_references.h>

#include <gtest/gtest.h>
#include <treelet/primitive/reference.h>

#include <bit>
#include <limits>
#include <stdexcept>
#include <string>

#include "cuda/device_input.h"
#include "cuda/schedules.h"
#include "support/mesh_params.h"
#include "support/random.h"

namespace treelet::cuda {
namespace {

using test::DeviceInput;
using test::OwnedMesh;

void expect_same_bits(Vec3 a, Vec3 b) {
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_EQ(std::bit_cast<std::uint32_t>(a[axis]), std::bit_cast<std::uint32_t>(b[axis]));
  }
}

void expect_scene_of_host(const DeviceScene& scene, const References& references) {
  expect_same_bits(scene.bounds.lower, references.bounds.lower);
  expect_same_bits(scene.bounds.upper, references.bounds.upper);
  EXPECT_EQ(scene.scale_exponent, references.scale_exponent);
  EXPECT_EQ(scene.reference_count, references.size());
  EXPECT_EQ(scene.left_out_non_finite, references.left_out_non_finite);
  EXPECT_EQ(scene.left_out_degenerate, references.left_out_degenerate);
  const MortonGrid grid = make_morton_grid(references.bounds);
  EXPECT_EQ(scene.grid.axis, grid.axis);
  EXPECT_EQ(scene.grid.bits, grid.bits);
  EXPECT_EQ(scene.grid.lower, grid.lower);
  EXPECT_EQ(scene.grid.scale, grid.scale);
}

class SurveyOfMeshes : public testing::TestWithParam<test::NamedMesh> {};
INSTANTIATE_TEST_SUITE_P(Meshes, SurveyOfMeshes, testing::ValuesIn(test::device_meshes()),
                         test::mesh_name);

TEST_P(SurveyOfMeshes, FindsWhatTheHostFinds) {
  const References references = create_references(GetParam().mesh.view());
  test::for_each_schedule([&](std::uint64_t seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const DeviceScene scene = DeviceInput(GetParam().mesh).scene();
    expect_scene_of_host(scene, references);
    EXPECT_EQ(scene.first_bad_face, DeviceScene::kNoFace);
  });
}

TEST(SurveyMesh, SlowTakesMoreFacesThanThreads) {
  const OwnedMesh mesh = test::soup_with_bad_faces(600'000, 201);
  expect_scene_of_host(DeviceInput(mesh).scene(), create_references(mesh.view()));
}

TEST(SurveyMesh, ScalesAsTheHostAtTheEndsOfTheRange) {
  constexpr float largest = std::numeric_limits<float>::max();
  for (const float extent : {0x1p-149f, 0x1p-130f, 0x1p-126f, 1e-30f, 1e30f, 0x1p127f, largest}) {
    OwnedMesh mesh;
    mesh.add({-extent, -0.0f, 0}, {extent, 0, 0}, {0, extent, -extent});
    expect_scene_of_host(DeviceInput(mesh).scene(), create_references(mesh.view()));
  }
}

/// What the host says about a mesh, or nothing.
std::string complaint_of_host(const OwnedMesh& mesh) {
  try {
    check_indices(mesh.view());
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return {};
}

std::string complaint_of_device(const OwnedMesh& mesh) {
  const DeviceInput input(mesh);
  try {
    require_valid_indices(input.mesh(), input.scene(), test::kStream);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return {};
}

TEST(SurveyMesh, NamesTheFirstBadFaceAsTheHost) {
  constexpr std::uint64_t seed = 202;
  SCOPED_TRACE("seed " + std::to_string(seed));
  test::Random random(seed);
  for (const std::size_t bad_faces : {0, 1, 2, 100}) {
    OwnedMesh mesh = test::triangle_soup(5000, seed);
    for (std::size_t i = 0; i < bad_faces; ++i) {
      const auto vertex = std::uint32_t(mesh.vertices.size() + random.below(2) * 0x8000'0000u);
      mesh.faces[random.below(5000)][random.below(3)] = vertex;
    }
    const std::string expected = complaint_of_host(mesh);
    EXPECT_EQ(expected.empty(), bad_faces == 0);
    EXPECT_EQ(complaint_of_device(mesh), expected);
  }
}

TEST(SurveyMesh, NamesFacesOfAMeshWithoutVertices) {
  const OwnedMesh mesh{{}, {{0, 0, 0}}};
  EXPECT_NE(complaint_of_host(mesh), "");
  EXPECT_EQ(complaint_of_device(mesh), complaint_of_host(mesh));
}

TEST(SurveyMesh, LeavesFacesWithBadIndicesOut) {
  OwnedMesh mesh = test::icosphere(2);
  const std::size_t good_faces = mesh.faces.size();
  const References references = create_references(mesh.view());
  for (int i = 0; i < 10; ++i) mesh.faces.push_back({0, 1, 0xffffffff});
  const DeviceScene scene = DeviceInput(mesh).scene();
  expect_scene_of_host(scene, references);
  EXPECT_EQ(scene.first_bad_face, good_faces);
}

}  // namespace
}  // namespace treelet::cuda
