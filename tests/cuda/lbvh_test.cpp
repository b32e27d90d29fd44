#include <treelet/build/lbvh.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "cuda/device_builds.h"
#include "cuda/device_input.h"
#include "cuda/schedules.h"
#include "support/mesh_params.h"
#include "support/trees.h"

namespace treelet::cuda {
namespace {

using test::DeviceInput;

BinaryTree build_on_device(const test::OwnedMesh& mesh) {
  return test::build_lbvh_on_device(DeviceInput(mesh).references());
}

BinaryTree build_on_host(const test::OwnedMesh& mesh) {
  const References references = create_references(mesh.view());
  return test::numbered_by_face(treelet::build_lbvh(references), references);
}

class DeviceLbvhOfMeshes : public testing::TestWithParam<test::NamedMesh> {};
INSTANTIATE_TEST_SUITE_P(Meshes, DeviceLbvhOfMeshes, testing::ValuesIn(test::device_meshes()),
                         test::mesh_name);

TEST_P(DeviceLbvhOfMeshes, IsTheHostsToTheByte) {
  const BinaryTree expected = build_on_host(GetParam().mesh);
  test::for_each_schedule([&](std::uint64_t seed) {
    EXPECT_TRUE(test::equal_bytes(build_on_device(GetParam().mesh), expected)) << "seed " << seed;
  });
}

TEST(DeviceLbvh, OfFewTrianglesIsTheHosts) {
  for (std::size_t count = 0; count < 40; ++count) {
    const test::OwnedMesh soup = test::triangle_soup(count, 221 + count);
    const test::OwnedMesh equal = test::equal_centres(count);
    EXPECT_TRUE(test::equal_bytes(build_on_device(soup), build_on_host(soup))) << count;
    EXPECT_TRUE(test::equal_bytes(build_on_device(equal), build_on_host(equal))) << count;
  }
}

TEST(DeviceLbvh, OfSplitReferencesIsTheHosts) {
  const test::OwnedMesh mesh = test::soup_with_bad_faces(3000, 222);
  const References references = create_references(mesh.view());
  const test::SplitDeviceInput input(mesh, references);
  EXPECT_TRUE(test::equal_bytes(test::build_lbvh_on_device(input.references()),
                                treelet::build_lbvh(references)));
}

TEST(DeviceLbvh, OfTheGoodFacesIsNotDisturbedByBadIndices) {
  const test::OwnedMesh good = test::triangle_soup(400, 223);
  test::OwnedMesh mesh = good;
  for (std::uint32_t i = 0; i < 50; ++i) mesh.faces.push_back({i, 0xffffffff - i, i});
  EXPECT_TRUE(test::equal_bytes(build_on_device(mesh), build_on_host(good)));
}

TEST(DeviceLbvh, SlowOfAHundredThousandTrianglesIsTheHosts) {
  const test::OwnedMesh mesh = test::triangle_soup(100'000, 224);
  EXPECT_TRUE(test::equal_bytes(build_on_device(mesh), build_on_host(mesh)));
}

TEST(DeviceLbvh, SlowOfAMillionEqualCodesIsTheHosts) {
  const test::OwnedMesh mesh = test::equal_centres(1'000'000);
  EXPECT_TRUE(test::equal_bytes(build_on_device(mesh), build_on_host(mesh)));
}

}  // namespace
}  // namespace treelet::cuda
