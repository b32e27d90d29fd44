#include <treelet/build/hploc.h>

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

#include "cuda/device_builds.h"
#include "cuda/device_input.h"
#include "cuda/schedules.h"
#include "support/errors.h"
#include "support/mesh_params.h"
#include "support/trees.h"

namespace treelet::cuda {
namespace {

using test::DeviceInput;

BinaryTree build_on_device(const test::OwnedMesh& mesh, const HplocConfig& config) {
  return test::build_hploc_on_device(DeviceInput(mesh).references(), config);
}

BinaryTree build_on_host(const test::OwnedMesh& mesh, const HplocConfig& config) {
  const References references = create_references(mesh.view());
  return test::numbered_by_face(treelet::build_hploc(references, config), references);
}

testing::AssertionResult builds_the_hosts_tree(const test::OwnedMesh& mesh,
                                               const HplocConfig& config = {}) {
  return test::equal_bytes(build_on_device(mesh, config), build_on_host(mesh, config))
         << "radius " << config.radius;
}

class DeviceHplocOfMeshes : public testing::TestWithParam<test::NamedMesh> {};
INSTANTIATE_TEST_SUITE_P(Meshes, DeviceHplocOfMeshes, testing::ValuesIn(test::device_meshes()),
                         test::mesh_name);

TEST_P(DeviceHplocOfMeshes, IsTheHostsToTheByte) {
  const BinaryTree expected = build_on_host(GetParam().mesh, {});
  test::for_each_schedule([&](std::uint64_t seed) {
    EXPECT_TRUE(test::equal_bytes(build_on_device(GetParam().mesh, {}), expected))
        << "seed " << seed;
  });
}

TEST_P(DeviceHplocOfMeshes, IsTheHostsForEveryRadius) {
  for (const int radius : {1, 2, 16}) {
    EXPECT_TRUE(builds_the_hosts_tree(GetParam().mesh, {.radius = radius}));
  }
}

// Counts about kHplocGoal and kHplocLanes, where nodes begin to merge and lists to be full.
TEST(DeviceHploc, OfFewTrianglesIsTheHosts) {
  for (std::size_t count = 0; count <= 70; ++count) {
    SCOPED_TRACE(count);
    EXPECT_TRUE(builds_the_hosts_tree(test::triangle_soup(count, 521 + count)));
    EXPECT_TRUE(builds_the_hosts_tree(test::equal_centres(count)));
    EXPECT_TRUE(builds_the_hosts_tree(test::identical_triangles(count), {.radius = 16}));
  }
}

TEST(DeviceHploc, OfSplitReferencesIsTheHosts) {
  const test::OwnedMesh mesh = test::soup_with_bad_faces(3000, 522);
  const References references = create_references(mesh.view());
  const test::SplitDeviceInput input(mesh, references);
  EXPECT_TRUE(test::equal_bytes(test::build_hploc_on_device(input.references()),
                                treelet::build_hploc(references)));
}

TEST(DeviceHploc, OfTheGoodFacesIsNotDisturbedByBadIndices) {
  const test::OwnedMesh good = test::triangle_soup(400, 523);
  test::OwnedMesh mesh = good;
  for (std::uint32_t i = 0; i < 50; ++i) mesh.faces.push_back({i, 0xffffffff - i, i});
  EXPECT_TRUE(test::equal_bytes(build_on_device(mesh, {}), build_on_host(good, {})));
}

TEST(DeviceHploc, TakesTheHostsRadii) {
  const test::OwnedMesh mesh = test::triangle_soup(20, 524);
  for (const int radius : {kMinHplocRadius - 1, kMaxHplocRadius + 1}) {
    const auto on_host = [&] { build_on_host(mesh, {.radius = radius}); };
    const auto on_device = [&] { build_on_device(mesh, {.radius = radius}); };
    EXPECT_EQ(test::error_of<std::invalid_argument>(on_device),
              test::error_of<std::invalid_argument>(on_host));
  }
}

TEST(DeviceHploc, SlowOfAHundredThousandTrianglesIsTheHosts) {
  EXPECT_TRUE(builds_the_hosts_tree(test::triangle_soup(100'000, 525)));
}

TEST(DeviceHploc, SlowOfManyBlocksOfEqualCodesIsTheHosts) {
  EXPECT_TRUE(builds_the_hosts_tree(test::equal_centres(30'000)));
}

}  // namespace
}  // namespace treelet::cuda
