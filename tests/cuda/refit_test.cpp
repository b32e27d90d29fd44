#include <treelet/tree/refit.h>

#include <gtest/gtest.h>

#include <bit>
#include <cstring>
#include <string>
#include <vector>

#include "cuda/device_input.h"
#include "cuda/schedules.h"
#include "support/mesh_params.h"
#include "support/trees.h"

namespace treelet::cuda {
namespace {

using test::DeviceInput;
using test::kStream;

/// A tree of the host in device memory, and its cut.
class CutTree {
 public:
  CutTree(const DeviceReferences& references, const BinaryTree& tree)
      : room_(references), cut_(test::carve(block_, [&](Carver& carver) {
          return carve_cut(carver, references.capacity);
        })) {
    room_.upload(tree);
    cut_tree(room_.tree(), cut_, kStream);
  }

  const DeviceTree& tree() const { return room_.tree(); }
  const DeviceCut& cut() const { return cut_; }
  BinaryTree download() const { return room_.download(); }

 private:
  test::DeviceTreeRoom room_;
  DeviceArray<std::byte> block_;
  DeviceCut cut_;
};

BinaryTree without_boxes(const BinaryTree& tree) {
  BinaryTree copy;
  copy.nodes = tree.nodes.clone();
  for (std::uint32_t slot = 0; slot < copy.nodes.size(); ++slot) {
    if (slot != 1) copy.nodes[slot].set_box({{7, 7, 7}, {8, 8, 8}});
  }
  return copy;
}

void expect_refit_as_on_host(const test::OwnedMesh& mesh, const References& references,
                             const BinaryTree& tree) {
  const BinaryTree expected = test::numbered_by_face(tree, references);
  const DeviceInput input(mesh);
  const CutTree device(input.references(), without_boxes(expected));
  refit(device.tree(), device.cut(), input.references(), kStream);
  EXPECT_TRUE(test::equal_bytes(device.download(), expected));
}

void expect_costs_as_on_host(const test::OwnedMesh& mesh, const References& references,
                             const BinaryTree& tree, const SahModel& sah) {
  const DeviceInput input(mesh);
  const CutTree device(input.references(), test::numbered_by_face(tree, references));
  DeviceArray<float> device_costs(2 * mesh.faces.size(), kStream);
  DeviceArray<double> device_cost(1, kStream);
  compute_costs(device.tree(), device.cut(), {}, sah, device_costs.data(), kStream);
  normalize_cost(device.tree(), device_costs.data(), device_cost.data(), kStream);
  const Array<float> expected = treelet::compute_costs(tree, sah);
  const Array<float> costs = download(device_costs.data(), expected.size(), kStream);
  for (std::size_t slot = 0; slot < expected.size(); ++slot) {
    ASSERT_EQ(std::bit_cast<std::uint32_t>(costs[slot]),
              std::bit_cast<std::uint32_t>(expected[slot]))
        << "slot " << slot;
  }
  EXPECT_EQ(download(device_cost)[0], sah_cost(tree, sah));
}

class DeviceRefitOfMeshes : public testing::TestWithParam<test::NamedMesh> {};
INSTANTIATE_TEST_SUITE_P(Meshes, DeviceRefitOfMeshes, testing::ValuesIn(test::device_meshes()),
                         test::mesh_name);

TEST_P(DeviceRefitOfMeshes, RestoresTheHostsBoxes) {
  const References references = create_references(GetParam().mesh.view());
  test::for_each_schedule([&](std::uint64_t seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const BinaryTree tree = test::random_tree(references, 231 + seed);
    expect_refit_as_on_host(GetParam().mesh, references, tree);
  });
}

TEST_P(DeviceRefitOfMeshes, ComputesTheHostsCosts) {
  const References references = create_references(GetParam().mesh.view());
  const BinaryTree tree = test::random_tree(references, 232);
  for (const SahModel& sah : {SahModel{}, SahModel{1.0f, 2.0f, 1}, SahModel{0.5f, 1.0f, 100}}) {
    expect_costs_as_on_host(GetParam().mesh, references, tree, sah);
  }
}

TEST(DeviceRefit, TakesTreesOfSeveralSubtrees) {
  const test::OwnedMesh mesh = test::triangle_soup(kSubtreeReferences + 2000, 238);
  const References references = create_references(mesh.view());
  const BinaryTree tree = test::random_tree(references, 239);
  expect_refit_as_on_host(mesh, references, tree);
  expect_costs_as_on_host(mesh, references, tree, SahModel{});
}

TEST(DeviceRefit, TakesChains) {
  const test::OwnedMesh mesh = test::triangle_soup(100, 240);
  const References references = create_references(mesh.view());
  const BinaryTree tree = test::chain_tree(references);
  expect_refit_as_on_host(mesh, references, tree);
  expect_costs_as_on_host(mesh, references, tree, SahModel{});
}

TEST(DeviceRefit, SlowTakesChainsFromTheTopIntoASubtree) {
  const test::OwnedMesh mesh = test::triangle_soup(kSubtreeReferences + 200, 233);
  const References references = create_references(mesh.view());
  const BinaryTree tree = test::chain_tree(references);
  expect_refit_as_on_host(mesh, references, tree);
  expect_costs_as_on_host(mesh, references, tree, SahModel{});
}

TEST(DeviceRefit, TakesTheBoxesOfSplitReferences) {
  const test::OwnedMesh mesh = test::soup_with_bad_faces(1000, 234);
  const References references = create_references(mesh.view());
  const BinaryTree tree = test::random_tree(references, 235);
  const test::SplitDeviceInput input(mesh, references);
  const DeviceReferences view = input.references();
  const CutTree device(view, without_boxes(tree));
  refit(device.tree(), device.cut(), view, kStream);
  EXPECT_TRUE(test::equal_bytes(device.download(), tree));
}

TEST(DeviceRefit, SlowOfAHundredThousandTrianglesIsTheHosts) {
  const test::OwnedMesh mesh = test::triangle_soup(100'000, 236);
  const References references = create_references(mesh.view());
  const BinaryTree tree = test::random_tree(references, 237);
  expect_refit_as_on_host(mesh, references, tree);
  expect_costs_as_on_host(mesh, references, tree, SahModel{});
}

}  // namespace
}  // namespace treelet::cuda
