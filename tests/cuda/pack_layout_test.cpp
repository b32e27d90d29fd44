#include <treelet/layout/device_pack.h>

#include <gtest/gtest.h>

#include <array>
#include <stdexcept>
#include <string>
#include <utility>

#include "cuda/device_packing.h"
#include "cuda/schedules.h"
#include "support/mesh_params.h"

namespace treelet::cuda {
namespace {

using test::DevicePackInput;

/// A mesh and a tree over it, to be packed on both sides.
struct Case {
  Case(const test::OwnedMesh& owned, BinaryTree owned_tree)
      : mesh(owned),
        references(create_references(owned.view())),
        tree(std::move(owned_tree)),
        input(owned, tree, references) {}
  explicit Case(const test::OwnedMesh& owned)
      : Case(owned, build_lbvh(create_references(owned.view()))) {}

  template <class Calls>
  typename Calls::Host on_host(const typename Calls::Model& model = {}) const {
    return Calls::pack_on_host(tree, references, mesh.view(), model);
  }
  template <class Calls>
  typename Calls::Host on_device(const typename Calls::Model& model = {}) const {
    test::DevicePacker<Calls> packer(input, model);
    packer.write();
    return packer.download();
  }
  template <class Calls>
  void expect_equal(const typename Calls::Model& model = {}) const {
    EXPECT_TRUE(test::equal_bytes(on_device<Calls>(model), on_host<Calls>(model)));
  }

  const test::OwnedMesh& mesh;
  const References references;
  const BinaryTree tree;
  const DevicePackInput input;
};

class DevicePack : public testing::TestWithParam<test::NamedMesh> {
 protected:
  template <class Calls>
  void expect_equal_for_every_tree() {
    const test::OwnedMesh& mesh = GetParam().mesh;
    for (auto& [name, tree] : test::trees_over(create_references(mesh.view()))) {
      const Case example(mesh, std::move(tree));
      for (const std::uint32_t leaf_limit : {1u, 2u, 4u, 8u, 16u, 64u}) {
        if (leaf_limit > 2 * Calls::kMaxLeaf) break;
        SCOPED_TRACE(name + ", leaf limit " + std::to_string(leaf_limit));
        example.expect_equal<Calls>(test::model_of_leaves<Calls>(leaf_limit));
      }
    }
  }

  template <class Calls>
  void expect_equal_in_any_order() {
    const Case example(GetParam().mesh);
    const auto expected = example.on_host<Calls>();
    test::for_each_schedule([&](std::uint64_t seed) {
      EXPECT_TRUE(test::equal_bytes(example.on_device<Calls>(), expected)) << "seed " << seed;
    });
  }
};
INSTANTIATE_TEST_SUITE_P(Meshes, DevicePack, testing::ValuesIn(test::hard_meshes()),
                         test::mesh_name);

TEST_P(DevicePack, SlowBvh2IsTheHostsToTheByteForEveryTree) {
  expect_equal_for_every_tree<test::Bvh2Calls>();
}
TEST_P(DevicePack, SlowBvh8IsTheHostsToTheByteForEveryTree) {
  expect_equal_for_every_tree<test::Bvh8Calls>();
}
TEST_P(DevicePack, SlowCwbvhIsTheHostsToTheByteForEveryTree) {
  expect_equal_for_every_tree<test::CwbvhCalls>();
}

TEST_P(DevicePack, Bvh2IsTheHostsInAnyOrderOfThreads) {
  expect_equal_in_any_order<test::Bvh2Calls>();
}
TEST_P(DevicePack, Bvh8IsTheHostsInAnyOrderOfThreads) {
  expect_equal_in_any_order<test::Bvh8Calls>();
}
TEST_P(DevicePack, CwbvhIsTheHostsInAnyOrderOfThreads) {
  expect_equal_in_any_order<test::CwbvhCalls>();
}

template <class Calls>
class DevicePackOf : public testing::Test {};
using Layouts = testing::Types<test::Bvh2Calls, test::Bvh8Calls, test::CwbvhCalls>;
TYPED_TEST_SUITE(DevicePackOf, Layouts);

TYPED_TEST(DevicePackOf, TakesEveryLeafLimit) {
  const test::OwnedMesh mesh = test::triangle_soup(200, 331);
  const Case example(mesh);
  for (std::uint32_t leaf_limit = 1; leaf_limit <= TypeParam::kMaxLeaf; ++leaf_limit) {
    SCOPED_TRACE("leaf limit " + std::to_string(leaf_limit));
    const auto model = test::model_of_leaves<TypeParam>(leaf_limit);
    example.expect_equal<TypeParam>(model);
    example.expect_equal<TypeParam>(test::with_dear_nodes(model));
  }
  for (const std::uint32_t leaf_limit : {0u, TypeParam::kMaxLeaf + 1}) {
    EXPECT_THROW(example.on_device<TypeParam>({.leaf_limit = leaf_limit}), std::invalid_argument);
  }
}

TYPED_TEST(DevicePackOf, FewTrianglesIsTheHosts) {
  for (std::size_t count = 0; count < 40; ++count) {
    SCOPED_TRACE(count);
    const test::OwnedMesh mesh = test::triangle_soup(count, 332 + count);
    Case(mesh).expect_equal<TypeParam>();
  }
}

TYPED_TEST(DevicePackOf, NodesAboveTheCutIsTheHosts) {
  const test::OwnedMesh mesh = test::triangle_soup(6'000, 333);
  const References references = create_references(mesh.view());
  for (BinaryTree& tree : std::array{build_lbvh(references), test::random_tree(references, 7)}) {
    const Case example(mesh, std::move(tree));
    for (const std::uint32_t leaf_limit : {1u, 8u}) {
      example.expect_equal<TypeParam>(test::model_of_leaves<TypeParam>(leaf_limit));
    }
  }
}

TYPED_TEST(DevicePackOf, SlowAChainThroughTheCutIsTheHosts) {
  const test::OwnedMesh mesh = test::triangle_soup(5'000, 334);
  Case(mesh, test::chain_tree(create_references(mesh.view()))).expect_equal<TypeParam>();
}

TYPED_TEST(DevicePackOf, SlowAHundredThousandTrianglesIsTheHosts) {
  const test::OwnedMesh mesh = test::triangle_soup(100'000, 335);
  Case(mesh).expect_equal<TypeParam>();
}

TYPED_TEST(DevicePackOf, FitsIntoMoreThanItTakes) {
  const test::OwnedMesh mesh = test::triangle_soup(500, 336);
  const Case example(mesh);
  test::DevicePacker<TypeParam> packer(example.input, {});
  const LayoutSize size = packer.planned();
  packer.write(size.nodes + 1000, size.items + 1);
  EXPECT_TRUE(test::equal_bytes(packer.download(), example.on_host<TypeParam>()));
  EXPECT_EQ(packer.summary().overflowed, 0u);
}

TYPED_TEST(DevicePackOf, WhatDoesNotFitIsEmptyAndSaysSo) {
  const test::OwnedMesh mesh = test::triangle_soup(500, 337);
  const Case example(mesh);
  test::DevicePacker<TypeParam> packer(example.input, {});
  const LayoutSize size = packer.planned();
  for (const auto& [nodes, items] : {std::pair{size.nodes - 1, size.items},
                                     std::pair{size.nodes, size.items - 1}, std::pair{1u, 1u}}) {
    packer.write(nodes, items);
    EXPECT_EQ(packer.summary().overflowed, 1u);
    EXPECT_TRUE(test::equal_bytes(packer.download(), typename TypeParam::Host{}));
  }
  packer.write(size.nodes, size.items);  // the plan is still good
  EXPECT_TRUE(test::equal_bytes(packer.download(), example.on_host<TypeParam>()));
}

TYPED_TEST(DevicePackOf, TakesOneEntryOfScratchAReference) {
  Carver carver;
  TypeParam::carve_scratch(carver, 1'000'000);
  EXPECT_LE(carver.peak(), TypeParam::kScratchPerReference * 1'000'000u + 512u);
}

}  // namespace
}  // namespace treelet::cuda
