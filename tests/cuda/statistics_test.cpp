#include <treelet/layout/device_statistics.h>

#include <gtest/gtest.h>

#include <string>

#include "cuda/device_packing.h"
#include "cuda/schedules.h"

namespace treelet::cuda {
namespace {

using test::DevicePackInput;
using test::kStream;

void expect_equal(const TreeStatistics& a, const TreeStatistics& b) {
  EXPECT_EQ(a.nodes, b.nodes);
  EXPECT_EQ(a.leaves, b.leaves);
  EXPECT_EQ(a.triangles, b.triangles);
  EXPECT_EQ(a.bytes, b.bytes);
  EXPECT_EQ(a.depth, b.depth);
  EXPECT_EQ(a.sah, b.sah);
  EXPECT_EQ(a.leaf_histogram, b.leaf_histogram);
}

template <class Calls>
class DeviceStatistics : public testing::Test {
 protected:
  void expect_equals_host(const test::OwnedMesh& mesh, const typename Calls::Model& model) {
    const References references = create_references(mesh.view());
    const BinaryTree tree = build_lbvh(references);
    const DevicePackInput input(mesh, tree, references);
    test::DevicePacker<Calls> packer(input, model);
    const LayoutSize size = packer.planned();
    packer.write(size.nodes + 700, size.items + 1);
    const SahModel sah{.traversal_cost = 1.7f};
    expect_equal(compute_statistics(packer.view(), sah, kStream),
                 treelet::compute_statistics(
                     Calls::pack_on_host(tree, references, mesh.view(), model), sah));
  }
};
using Layouts = testing::Types<test::Bvh2Calls, test::Bvh8Calls, test::CwbvhCalls>;
TYPED_TEST_SUITE(DeviceStatistics, Layouts);

TYPED_TEST(DeviceStatistics, AreTheHostsToTheLastBitOnHardMeshes) {
  for (const auto& [name, mesh] : test::hard_meshes()) {
    for (const std::uint32_t leaf_limit : {1u, 8u, 16u}) {
      SCOPED_TRACE(name + ", leaf limit " + std::to_string(leaf_limit));
      this->expect_equals_host(mesh, test::model_of_leaves<TypeParam>(leaf_limit));
    }
  }
}

TYPED_TEST(DeviceStatistics, OfManyNodesAreTheHostsInAnyOrderOfThreads) {
  const test::OwnedMesh mesh = test::triangle_soup(6'000, 381);
  test::for_each_schedule([&](std::uint64_t seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    this->expect_equals_host(mesh, {.leaf_limit = 2});
  });
}

TEST(DeviceStatisticsOfBvh2, CountLargeLeaves) {
  const test::OwnedMesh mesh = test::identical_triangles(64);
  const References references = create_references(mesh.view());
  const BinaryTree tree = build_lbvh(references);
  const DevicePackInput input(mesh, tree, references);
  const SahModel sah{.traversal_cost = 1000.0f, .leaf_limit = 64};
  test::DevicePacker<test::Bvh2Calls> packer(input, sah);
  packer.write();
  const TreeStatistics statistics = compute_statistics(packer.view(), sah, kStream);
  ASSERT_EQ(statistics.leaf_histogram.size(), 65u);
  EXPECT_EQ(statistics.leaf_histogram[64], 1u);
  EXPECT_EQ(statistics.leaves, 1u);
}

}  // namespace
}  // namespace treelet::cuda
