#include <treelet/optimize/treelet.h>

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <vector>

#include <treelet/build/lbvh.h>
#include <treelet/build/sweep.h>
#include <treelet/optimize/subset_tables.h>

#include "cuda/schedules.h"
#include "cuda/uploaded_tree.h"
#include "support/mesh_params.h"
#include "support/meshes.h"
#include "support/trees.h"

namespace treelet::cuda {
namespace {

using test::kStream;

BinaryTree copy_of(const BinaryTree& tree) {
  BinaryTree copy;
  copy.nodes = tree.nodes.clone();
  return copy;
}

BinaryTree restructure_on_device(const BinaryTree& tree, const SahModel& sah,
                                 const TreeletConfig& config, std::uint32_t spare = 0) {
  test::UploadedTree uploaded(tree, spare);
  DeviceArray<std::byte> block;
  const TreeletBuffers buffers = test::carve(block, [&](Carver& carver) {
    return carve_treelet_buffers(carver, uploaded.tree().capacity);
  });
  restructure_treelets(uploaded.tree(), sah, config, buffers, kStream);
  return uploaded.download();
}

std::string describe(const TreeletConfig& config) {
  return "size " + std::to_string(config.size) + ", rounds " + std::to_string(config.rounds) +
         ", gamma " + std::to_string(config.gamma);
}

void expect_as_on_host(const BinaryTree& tree, const TreeletConfig& config,
                       const SahModel& sah = {}) {
  SCOPED_TRACE(describe(config));
  BinaryTree expected = copy_of(tree);
  treelet::restructure_treelets(expected, sah, config);
  EXPECT_TRUE(test::equal_bytes(restructure_on_device(tree, sah, config), expected));
}

References soup(std::size_t count, std::uint64_t seed) {
  return create_references(test::triangle_soup(count, seed).view());
}

class DeviceTreeletsOfMeshes : public testing::TestWithParam<test::NamedMesh> {
 protected:
  const References references_ = create_references(GetParam().mesh.view());
};
INSTANTIATE_TEST_SUITE_P(Meshes, DeviceTreeletsOfMeshes, testing::ValuesIn(test::hard_meshes()),
                         test::mesh_name);

TEST_P(DeviceTreeletsOfMeshes, SlowAreTheHostsOfAllSizes) {
  const BinaryTree built = build_lbvh(references_), scrambled = test::random_tree(references_, 501);
  for (int size = kMinTreeletSize; size <= kMaxTreeletSize; ++size) {
    expect_as_on_host(built, {.size = size, .rounds = 2});
    expect_as_on_host(scrambled, {.size = size, .rounds = 1});
  }
}

TEST_P(DeviceTreeletsOfMeshes, AreTheHostsForAllRoundsAndGammas) {
  const BinaryTree built = build_lbvh(references_);
  for (int rounds = 0; rounds <= 4; ++rounds) expect_as_on_host(built, {.rounds = rounds});
  for (const std::uint32_t gamma : {1u, 2u, 3u, 30u, 500u, 4000000000u}) {
    expect_as_on_host(built, {.rounds = 3, .gamma = gamma});
  }
}

TEST_P(DeviceTreeletsOfMeshes, AreTheHostsInAnyOrderOfThreads) {
  const BinaryTree swept = build_sweep(references_),
                   scrambled = test::random_tree(references_, 502);
  test::for_each_schedule([&](std::uint64_t seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    expect_as_on_host(swept, {});
    expect_as_on_host(scrambled, {.size = 8, .gamma = 2}, {.leaf_limit = 2});
  });
}

// Four roots without a listed child, so that warps meet twice on the way up; few treelets below.
TEST(DeviceTreelets, AboveTheCutAreTheHosts) {
  const BinaryTree scrambled = test::balanced_tree(soup(4 * (kSubtreeReferences + 1), 503));
  test::for_each_schedule([&](std::uint64_t seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    expect_as_on_host(scrambled, {.rounds = 2, .gamma = 2000});
    expect_as_on_host(scrambled, {.rounds = 1, .gamma = 5000});
  });
}

TEST(DeviceTreelets, SlowOfSeveralSubtreesAreTheHostsInAnyOrderOfThreads) {
  const References references = soup(20'000, 503);
  const BinaryTree built = build_lbvh(references);
  test::for_each_schedule([&](std::uint64_t seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    expect_as_on_host(built, {});
  });
}

// Gammas above the cut leave the subtrees alone, but their costs count.
TEST(DeviceTreelets, OfGammasAroundTheCutAreTheHosts) {
  const BinaryTree scrambled = test::random_tree(soup(9000, 505), 506);
  for (const std::uint32_t gamma : {4096u, 4097u, 4098u, 9000u, 9001u}) {
    expect_as_on_host(scrambled, {.rounds = 2, .gamma = gamma});
  }
}

TEST(DeviceTreelets, OfSizesAroundASubtreeAreTheHosts) {
  for (const std::size_t count : {4095u, 4096u, 4097u, 8200u}) {
    SCOPED_TRACE(std::to_string(count) + " references");
    expect_as_on_host(test::random_tree(soup(count, 507), 508), {.rounds = 2, .gamma = 60});
  }
}

TEST(DeviceTreelets, OfFewReferencesAreTheHosts) {
  for (std::size_t count = 0; count <= 40; ++count) {
    SCOPED_TRACE(std::to_string(count) + " references");
    const BinaryTree tree = test::random_tree(soup(count, 509 + count), 510);
    for (int size = kMinTreeletSize; size <= kMaxTreeletSize; ++size) {
      expect_as_on_host(tree, {.size = size, .rounds = 4, .gamma = 1}, {.leaf_limit = 1});
    }
  }
}

// Where the order of equal costs and equal areas shows.
TEST(DeviceTreelets, OfEqualReferencesAreTheHosts) {
  const References equal = create_references(test::identical_triangles(1500).view());
  const References grid = create_references(test::coplanar_grid(25).view());
  for (const std::uint32_t leaf_limit : {1u, 8u}) {
    for (const int size : {4, 7, 8}) {
      expect_as_on_host(test::random_tree(equal, 511), {.size = size}, {.leaf_limit = leaf_limit});
      expect_as_on_host(test::random_tree(grid, 512), {.size = size}, {.leaf_limit = leaf_limit});
    }
  }
}

TEST(DeviceTreelets, OfChainsAreTheHosts) {
  expect_as_on_host(test::chain_tree(soup(300, 513)), {});
  expect_as_on_host(test::chain_tree(soup(kSubtreeReferences + 300, 514)),
                    {.rounds = 1, .gamma = 4200});
}

TEST(DeviceTreelets, SlowOfAChainOfAllTopNodesAreTheHosts) {
  expect_as_on_host(test::chain_tree(soup(kSubtreeReferences + 500, 515)), {.rounds = 2});
}

// Only the device knows how many references took part.
TEST(DeviceTreelets, TouchNothingBehindTheTree) {
  const BinaryTree tree = test::random_tree(soup(5000, 516), 517);
  for (const TreeletConfig& config : {TreeletConfig{}, TreeletConfig{.gamma = 5001}}) {
    BinaryTree expected = copy_of(tree);
    treelet::restructure_treelets(expected, {}, config);
    EXPECT_TRUE(test::equal_bytes(restructure_on_device(tree, {}, config, 9000), expected));
  }
  EXPECT_TRUE(restructure_on_device({}, {}, {}, 9000).empty());
}

TEST(DeviceTreelets, OfOtherCostModelsAreTheHosts) {
  const BinaryTree tree = build_lbvh(soup(6000, 518));
  expect_as_on_host(tree, {}, {.traversal_cost = 0.1f, .intersection_cost = 3.0f});
  expect_as_on_host(tree, {},
                    {.traversal_cost = 4.0f, .intersection_cost = 0.5f, .leaf_limit = 64});
}

TEST(DeviceTreelets, RefuseSizesThatTheirTablesDoNotHold) {
  for (const int size : {3, 9, -1}) {
    try {
      restructure_on_device(test::random_tree(soup(10, 519), 520), {}, {.size = size});
      ADD_FAILURE() << "size " << size << " was accepted";
    } catch (const std::invalid_argument& error) {
      EXPECT_EQ(error.what(), "treelets have 4 to 8 leaves, not " + std::to_string(size));
    }
  }
}

TEST(DeviceTreelets, SlowOfAHundredThousandTrianglesAreTheHosts) {
  const References references = soup(100'000, 521);
  expect_as_on_host(build_lbvh(references), {});
  expect_as_on_host(test::random_tree(references, 522), {.rounds = 2});
}

}  // namespace
}  // namespace treelet::cuda
