#include <treelet/layout/device_epo.h>

#include <gtest/gtest.h>

#include <treelet/layout/epo.h>

#include <string>

#include "cuda/device_packing.h"
#include "cuda/schedules.h"

namespace treelet::cuda {
namespace {

using test::DevicePackInput;
using test::kStream;

template <class Calls>
class DeviceEpo : public testing::Test {
 protected:
  /// Packs a tree of much overlap and compares, from so many triangles.
  void expect_equal(const test::OwnedMesh& mesh, std::size_t max_triangles = 0) {
    const References references = create_references(mesh.view());
    const BinaryTree tree = test::random_tree(references, 371);
    const auto model = test::model_of_leaves<Calls>(4);
    const auto expected = Calls::pack_on_host(tree, references, mesh.view(), model);
    const DevicePackInput input(mesh, tree, references);
    test::DevicePacker<Calls> packer(input, model);
    packer.write();
    const auto face_count = std::uint32_t(mesh.faces.size());
    EXPECT_EQ(compute_epo(packer.view(), SahModel{}, face_count, kStream, max_triangles),
              treelet::compute_epo(expected, SahModel{}, max_triangles));
  }
};
using Layouts = testing::Types<test::Bvh2Calls, test::Bvh8Calls, test::CwbvhCalls>;
TYPED_TEST_SUITE(DeviceEpo, Layouts);

TYPED_TEST(DeviceEpo, IsTheHostsToTheLastBitOnHardMeshes) {
  for (const auto& [name, mesh] : test::hard_meshes()) {
    SCOPED_TRACE(name);
    this->expect_equal(mesh);
  }
}

TYPED_TEST(DeviceEpo, IsTheHostsInAnyOrderOfThreads) {
  const test::OwnedMesh mesh = test::soup_with_bad_faces(400, 372);
  test::for_each_schedule([&](std::uint64_t seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    this->expect_equal(mesh);
  });
}

TYPED_TEST(DeviceEpo, AnEstimateIsTheHosts) {
  const test::OwnedMesh mesh = test::soup_with_bad_faces(900, 373);
  for (const std::size_t max_triangles : {1, 255, 256, 257, 400, 100'000}) {
    SCOPED_TRACE(max_triangles);
    this->expect_equal(mesh, max_triangles);
  }
}

TYPED_TEST(DeviceEpo, OfOneTriangleAndOfNoneIsZero) {
  this->expect_equal(test::one_triangle());
  this->expect_equal(test::empty_mesh());
  this->expect_equal(test::degenerate_triangles(300));
}

TYPED_TEST(DeviceEpo, SlowOfManyTrianglesIsTheHosts) {
  this->expect_equal(test::triangle_soup(3'000, 374));
}

}  // namespace
}  // namespace treelet::cuda
