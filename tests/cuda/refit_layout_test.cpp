#include <treelet/layout/device_refit_layout.h>

#include <gtest/gtest.h>

#include <treelet/layout/refit_layout.h>

#include <limits>
#include <string>
#include <vector>

#include "cuda/device_packing.h"
#include "cuda/schedules.h"
#include "support/mesh_params.h"
#include "support/random.h"

namespace treelet::cuda {
namespace {

using test::DevicePackInput;
using test::kStream;

std::vector<Vec3> shaken(std::vector<Vec3> vertices, std::uint64_t seed) {
  test::Random random(seed);
  for (Vec3& vertex : vertices) vertex = vertex * 1.5f + random.point(-0.3f, 0.3f);
  return vertices;
}

/// Some vertices become NaN or infinite, and some triangles a point.
std::vector<Vec3> broken(const test::OwnedMesh& mesh, std::uint64_t seed) {
  test::Random random(seed);
  std::vector<Vec3> vertices = shaken(mesh.vertices, seed);
  for (std::size_t i = 0; i < vertices.size(); i += 7) {
    vertices[random.below(vertices.size())].y = i % 2 == 0 ? std::numeric_limits<float>::quiet_NaN()
                                                           : std::numeric_limits<float>::infinity();
  }
  for (std::size_t i = 0; i < mesh.faces.size(); i += 5) {
    vertices[mesh.faces[i][1]] = vertices[mesh.faces[i][0]];
  }
  return vertices;
}

template <class Calls>
class DeviceRefit : public testing::Test {
 protected:
  /// Packs and refits on both sides.
  void expect_equal(const test::OwnedMesh& mesh, const std::vector<Vec3>& moved) {
    const References references = create_references(mesh.view());
    const BinaryTree tree = build_lbvh(references);
    typename Calls::Host expected = Calls::pack_on_host(tree, references, mesh.view(), {});
    const RefitResult result = treelet::refit(expected, Mesh{moved, mesh.faces}, SahModel{});

    DevicePackInput input(mesh, tree, references);
    test::DevicePacker<Calls> packer(input, {});
    packer.write();
    input.move_vertices(moved);
    DeviceArray<LinkOf<typename Calls::Layout>> links(packer.view().node_capacity, kStream);
    refit(packer.view(), input.mesh(), links.data(), kStream);
    EXPECT_TRUE(test::equal_bytes(packer.download(), expected));
    EXPECT_EQ(packer.summary().hidden, result.hidden);
  }
};
using Layouts = testing::Types<test::Bvh2Calls, test::Bvh8Calls, test::CwbvhCalls>;
TYPED_TEST_SUITE(DeviceRefit, Layouts);

TYPED_TEST(DeviceRefit, IsTheHostsToTheByteOnHardMeshes) {
  for (const auto& [name, mesh] : test::hard_meshes()) {
    SCOPED_TRACE(name);
    this->expect_equal(mesh, mesh.vertices);
    this->expect_equal(mesh, shaken(mesh.vertices, 351));
    this->expect_equal(mesh, broken(mesh, 352));
  }
}

TYPED_TEST(DeviceRefit, IsTheHostsInAnyOrderOfThreads) {
  const test::OwnedMesh mesh = test::triangle_soup(600, 353);
  test::for_each_schedule([&](std::uint64_t seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    this->expect_equal(mesh, broken(mesh, 354));
  });
}

TYPED_TEST(DeviceRefit, HidesALeafThatHasNoFiniteVertex) {
  test::OwnedMesh mesh = test::triangle_soup(100, 355);
  std::vector<Vec3> moved = mesh.vertices;
  for (Vec3& vertex : moved) vertex.x = std::numeric_limits<float>::quiet_NaN();
  this->expect_equal(mesh, moved);
}

TYPED_TEST(DeviceRefit, SlowOfManyTrianglesIsTheHosts) {
  const test::OwnedMesh mesh = test::triangle_soup(50'000, 356);
  this->expect_equal(mesh, shaken(mesh.vertices, 357));
}

TYPED_TEST(DeviceRefit, OfTheMeshItWasPackedFromChangesNothing) {
  const test::OwnedMesh mesh = test::triangle_soup(300, 358);
  const References references = create_references(mesh.view());
  const DevicePackInput input(mesh, build_lbvh(references), references);
  test::DevicePacker<TypeParam> packer(input, {});
  packer.write();
  const auto before = packer.download();
  DeviceArray<LinkOf<typename TypeParam::Layout>> links(packer.view().node_capacity, kStream);
  refit(packer.view(), input.mesh(), links.data(), kStream);
  EXPECT_TRUE(test::equal_bytes(packer.download(), before));
}

TYPED_TEST(DeviceRefit, OfALayoutThatOverflowedDoesNothing) {
  const test::OwnedMesh mesh = test::triangle_soup(300, 359);
  const References references = create_references(mesh.view());
  const DevicePackInput input(mesh, build_lbvh(references), references);
  test::DevicePacker<TypeParam> packer(input, {});
  packer.write(5, 5);
  DeviceArray<LinkOf<typename TypeParam::Layout>> links(5, kStream);
  refit(packer.view(), input.mesh(), links.data(), kStream);
  EXPECT_TRUE(test::equal_bytes(packer.download(), typename TypeParam::Host{}));
}

}  // namespace
}  // namespace treelet::cuda
