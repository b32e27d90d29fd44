#include <treelet/layout/device_pack.h>

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

#include "cuda/device_packing.h"
#include "cuda/schedules.h"
#include "support/mesh_params.h"

namespace treelet::cuda {
namespace {

using test::DevicePackInput;
using test::kStream;
using Packer = test::DevicePacker<test::Bvh8Calls>;

Bvh8 pack_on_device(const DevicePackInput& input, const WideCostModel& model) {
  Packer packer(input, model);
  packer.write();
  return packer.download();
}

/// Packs the lbvh.
struct Case {
  explicit Case(const test::OwnedMesh& owned)
      : mesh(owned),
        references(create_references(owned.view())),
        tree(build_lbvh(references)),
        input(owned, tree, references) {}

  Bvh8 on_host(const WideCostModel& model) const {
    return treelet::pack_bvh8(tree, references, mesh.view(), model);
  }

  const test::OwnedMesh& mesh;
  const References references;
  const BinaryTree tree;
  const DevicePackInput input;
};

class DevicePackBvh8 : public testing::TestWithParam<test::NamedMesh> {};
INSTANTIATE_TEST_SUITE_P(Meshes, DevicePackBvh8, testing::ValuesIn(test::hard_meshes()),
                         test::mesh_name);

TEST_P(DevicePackBvh8, SlowIsTheHostsToTheByteForEveryTree) {
  const test::OwnedMesh& mesh = GetParam().mesh;
  const References references = create_references(mesh.view());
  for (const auto& [name, tree] : test::trees_over(references)) {
    const DevicePackInput input(mesh, tree, references);
    for (const std::uint32_t leaf_limit : {1u, 4u, 8u, 16u}) {
      SCOPED_TRACE(name + ", leaf limit " + std::to_string(leaf_limit));
      const WideCostModel model{.leaf_limit = leaf_limit};
      EXPECT_TRUE(test::equal_bytes(pack_on_device(input, model),
                                    pack_bvh8(tree, references, mesh.view(), model)));
    }
  }
}

TEST_P(DevicePackBvh8, IsTheHostsInAnyOrderOfThreads) {
  const Case example(GetParam().mesh);
  const Bvh8 expected = example.on_host({});
  test::for_each_schedule([&](std::uint64_t seed) {
    EXPECT_TRUE(test::equal_bytes(pack_on_device(example.input, {}), expected)) << "seed " << seed;
  });
}

TEST(DevicePackBvh8, TakesEveryLeafLimit) {
  const test::OwnedMesh mesh = test::triangle_soup(200, 331);
  const Case example(mesh);
  for (std::uint32_t leaf_limit = 1; leaf_limit <= 16; ++leaf_limit) {
    const WideCostModel model{.block_cost = 0.1f, .leaf_limit = leaf_limit};
    EXPECT_TRUE(test::equal_bytes(pack_on_device(example.input, model), example.on_host(model)))
        << "leaf limit " << leaf_limit;
  }
  for (const std::uint32_t leaf_limit : {0u, 17u}) {
    EXPECT_THROW(pack_on_device(example.input, {.leaf_limit = leaf_limit}), std::invalid_argument);
  }
}

TEST(DevicePackBvh8, OfFewTrianglesIsTheHosts) {
  for (std::size_t count = 0; count < 40; ++count) {
    const test::OwnedMesh mesh = test::triangle_soup(count, 332 + count);
    const Case example(mesh);
    EXPECT_TRUE(test::equal_bytes(pack_on_device(example.input, {}), example.on_host({}))) << count;
  }
}

TEST(DevicePackBvh8, OfNodesAboveTheCutIsTheHosts) {
  const test::OwnedMesh mesh = test::triangle_soup(6'000, 333);
  const References references = create_references(mesh.view());
  for (const BinaryTree& tree : {build_lbvh(references), test::random_tree(references, 7)}) {
    const DevicePackInput input(mesh, tree, references);
    for (const std::uint32_t leaf_limit : {1u, 8u}) {
      const WideCostModel model{.leaf_limit = leaf_limit};
      EXPECT_TRUE(test::equal_bytes(pack_on_device(input, model),
                                    pack_bvh8(tree, references, mesh.view(), model)));
    }
  }
}

TEST(DevicePackBvh8, SlowOfAChainThroughTheCutIsTheHosts) {
  const test::OwnedMesh mesh = test::triangle_soup(5'000, 334);
  const References references = create_references(mesh.view());
  const BinaryTree tree = test::chain_tree(references);
  const DevicePackInput input(mesh, tree, references);
  EXPECT_TRUE(
      test::equal_bytes(pack_on_device(input, {}), pack_bvh8(tree, references, mesh.view(), {})));
}

TEST(DevicePackBvh8, SlowOfAHundredThousandTrianglesIsTheHosts) {
  const test::OwnedMesh mesh = test::triangle_soup(100'000, 335);
  const Case example(mesh);
  EXPECT_TRUE(test::equal_bytes(pack_on_device(example.input, {}), example.on_host({})));
}

TEST(DevicePackBvh8, FitsIntoMoreThanItTakes) {
  const test::OwnedMesh mesh = test::triangle_soup(500, 336);
  const Case example(mesh);
  Packer packer(example.input, {});
  const LayoutSize size = packer.planned();
  packer.write(size.nodes + 1000, size.items + 1);
  EXPECT_TRUE(test::equal_bytes(packer.download(), example.on_host({})));
  EXPECT_EQ(packer.summary().overflowed, 0u);
}

TEST(DevicePackBvh8, ThatDoesNotFitIsEmptyAndSaysSo) {
  const test::OwnedMesh mesh = test::triangle_soup(500, 337);
  const Case example(mesh);
  Packer packer(example.input, {});
  const LayoutSize size = packer.planned();
  for (const auto& [nodes, items] : {std::pair{size.nodes - 1, size.items},
                                     std::pair{size.nodes, size.items - 1}, std::pair{1u, 1u}}) {
    packer.write(nodes, items);
    EXPECT_EQ(packer.summary().overflowed, 1u);
    EXPECT_TRUE(test::equal_bytes(packer.download(), Bvh8{}));
  }
  packer.write(size.nodes, size.items);  // the plan is still good
  EXPECT_TRUE(test::equal_bytes(packer.download(), example.on_host({})));
}

TEST(DevicePackBvh8, TakesAtMost32BytesOfScratchAReference) {
  Carver carver;
  carve_bvh8_scratch(carver, 1'000'000);
  EXPECT_LE(carver.peak(), 32'000'000u + 512u);
}

}  // namespace
}  // namespace treelet::cuda
