#include <treelet/layout/device_pack.h>

#include <gtest/gtest.h>

#include <treelet/layout/device_face_counts.h>
#include <treelet/layout/face_counts.h>
#include <treelet/layout/leaf_collapse.h>
#include <treelet/primitive/split.h>
#include <treelet/tree/refit.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "cuda/device_packing.h"
#include "cuda/schedules.h"
#include "support/mesh_params.h"
#include "support/random.h"

namespace treelet::cuda {
namespace {

using test::kStream;

References split(const test::OwnedMesh& mesh, std::size_t percent) {
  References references = create_references(mesh.view());
  split_references(references, mesh.view(), references.size() * percent / 100);
  return references;
}

/// What recipes build.
std::vector<test::NamedTree> built_trees(const References& references) {
  BinaryTree optimized = build_lbvh(references);
  restructure_treelets(optimized, SahModel{}, TreeletConfig{});
  std::vector<test::NamedTree> trees;
  trees.push_back({"lbvh", build_lbvh(references)});
  trees.push_back({"lbvh > treelet", std::move(optimized)});
  trees.push_back({"sweep", build_sweep(references)});
  return trees;
}

/// Split references of the host and a tree over them in device memory, cut, with room for more.
class SplitInput {
 public:
  SplitInput(const test::OwnedMesh& mesh, const BinaryTree& tree, const References& references)
      : capacity_(std::uint32_t(references.size() + 5)),
        vertices_(test::upload_all(std::span(mesh.vertices))),
        faces_(test::upload_all(std::span(mesh.faces))),
        references_(capacity_, kStream),
        nodes_(2 * std::size_t(capacity_), kStream),
        scene_(1, kStream) {
    const DeviceScene scene{references.bounds,
                            references.scale_exponent,
                            make_morton_grid(references.bounds),
                            std::uint32_t(references.size()),
                            std::uint32_t(references.left_out_non_finite),
                            std::uint32_t(references.left_out_degenerate),
                            DeviceScene::kNoFace};
    copy_to_device(scene_.data(), &scene, sizeof scene, kStream);
    copy(references.items, references_);
    copy(tree.nodes, nodes_);
    cut_ = test::carve(cut_block_, [&](Carver& carver) { return carve_cut(carver, capacity_); });
    counts_ = test::carve(counts_block_,
                          [&](Carver& carver) { return carve_subtree_faces(carver, capacity_); });
    scratch_ = test::carve(scratch_block_, [&](Carver& carver) {
      return carve_face_count_scratch(carver, capacity_);
    });
    cut_tree(this->tree(), cut_, kStream);
  }

  /// Counts the faces anew: planning may use the counts up.
  PackInput pack_input() const {
    const DeviceReferences references{
        {vertices_.data(), faces_.data(), std::uint32_t(vertices_.size()),
         std::uint32_t(faces_.size())},
        scene_.data(),
        references_.data(),
        capacity_};
    count_faces(tree(), cut_, references, scratch_, counts_, kStream);
    return {tree(), cut_, references, counts_};
  }

 private:
  template <class T>
  static void copy(const Array<T>& from, DeviceArray<T>& to) {
    fill_device_bytes(to.data(), 0xcd, to.bytes(), kStream);
    if (from.size() > 0) copy_to_device(to.data(), from.data(), from.bytes(), kStream);
    synchronize(kStream);
  }

  DeviceTree tree() const {
    return {const_cast<BinaryNode*>(nodes_.data()), &scene_.data()->reference_count, capacity_};
  }

  std::uint32_t capacity_;
  DeviceArray<Vec3> vertices_;
  DeviceArray<Face> faces_;
  DeviceArray<Reference> references_;
  DeviceArray<BinaryNode> nodes_;
  DeviceArray<DeviceScene> scene_;
  DeviceArray<std::byte> cut_block_, counts_block_, scratch_block_;
  DeviceCut cut_;
  SubtreeFaces counts_;
  FaceCountScratch scratch_;
};

template <class Calls>
testing::AssertionResult packs_as_the_host(const SplitInput& input, const test::OwnedMesh& mesh,
                                           const BinaryTree& tree, const References& references,
                                           const typename Calls::Model& model) {
  test::DevicePacker<Calls> packer(input, model);
  packer.write();
  return test::equal_bytes(packer.download(),
                           Calls::pack_on_host(tree, references, mesh.view(), model));
}

void expect_equal_layouts(const test::OwnedMesh& mesh, const BinaryTree& tree,
                          const References& references, std::uint32_t leaf_limit) {
  const SplitInput input(mesh, tree, references);
  SCOPED_TRACE("leaf limit " + std::to_string(leaf_limit));
  const auto expect_equal = [&]<class Calls>(Calls) {
    EXPECT_TRUE(packs_as_the_host<Calls>(input, mesh, tree, references,
                                         test::model_of_leaves<Calls>(leaf_limit)));
  };
  expect_equal(test::Bvh2Calls{});
  expect_equal(test::Bvh8Calls{});
  expect_equal(test::CwbvhCalls{});
}

void expect_equal_counts(const BinaryTree& tree, const References& references,
                         const SplitInput& input) {
  const FaceCounts expected(tree, references);
  const SubtreeFaces faces = input.pack_input().faces;
  const Array<std::uint32_t> counts = download(faces.counts, tree.reference_count(), kStream);
  for (std::size_t slot = 0; slot < tree.nodes.size(); ++slot) {
    const BinaryNode& node = tree.nodes[slot];
    if (slot == 1 || node.is_leaf()) continue;
    ASSERT_EQ(counts[node.left() / 2], expected[slot]) << "slot " << slot;
  }
}

class DevicePackSplit : public testing::TestWithParam<test::NamedMesh> {};
INSTANTIATE_TEST_SUITE_P(Meshes, DevicePackSplit, testing::ValuesIn(test::hard_meshes()),
                         test::mesh_name);

TEST_P(DevicePackSplit, SlowIsTheHostsToTheByteForEveryRecipe) {
  const test::OwnedMesh& mesh = GetParam().mesh;
  for (const std::size_t percent : {10, 30, 300}) {
    const References references = split(mesh, percent);
    for (const auto& [name, tree] : built_trees(references)) {
      SCOPED_TRACE(name + ", budget " + std::to_string(percent));
      for (const std::uint32_t leaf_limit : {1u, 4u, 8u, 16u}) {
        expect_equal_layouts(mesh, tree, references, leaf_limit);
      }
    }
  }
}

TEST_P(DevicePackSplit, IsTheHostsInAnyOrderOfThreads) {
  const test::OwnedMesh& mesh = GetParam().mesh;
  const References references = split(mesh, 100);
  const BinaryTree tree = build_lbvh(references);
  test::for_each_schedule([&](std::uint64_t seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    expect_equal_layouts(mesh, tree, references, 8);
  });
}

TEST_P(DevicePackSplit, CostsWhatTheHostSays) {
  const References references = split(GetParam().mesh, 100);
  for (const auto& [name, tree] : built_trees(references)) {
    SCOPED_TRACE(name);
    const SplitInput input(GetParam().mesh, tree, references);
    const PackInput on_device = input.pack_input();
    DeviceArray<float> costs(2 * std::size_t(on_device.tree.capacity), kStream);
    DeviceArray<double> cost(1, kStream);
    compute_costs(on_device.tree, on_device.cut, on_device.faces, {}, costs.data(), kStream);
    normalize_cost(on_device.tree, costs.data(), cost.data(), kStream);
    EXPECT_EQ(download(cost)[0], collapsed_sah_cost(tree, references, {}));
  }
}

TEST(DeviceFaceCounts, SlowAreTheHostsWhereverThePiecesLie) {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const test::OwnedMesh mesh = test::triangle_soup(40, seed);
    test::Random random(seed);
    References references =
        test::references_of(std::vector<Aabb>(1 + 97 * (seed - 1), {{0, 0, 0}, {1, 1, 1}}));
    references.may_repeat_faces = true;
    std::uint32_t face = 0;
    for (Reference& item : references.items) item.face = face += random.below(9) == 0;
    for (const BinaryTree& tree :
         {test::random_tree(references, seed), test::chain_tree(references)}) {
      expect_equal_counts(tree, references, SplitInput(mesh, tree, references));
    }
  }
}

TEST(DeviceFaceCounts, OfNodesAboveTheCutAreTheHostsInAnyOrderOfThreads) {
  const test::OwnedMesh mesh = test::triangle_soup(5'000, 11);
  const References references = split(mesh, 100);
  for (const BinaryTree& tree : {build_lbvh(references), test::random_tree(references, 12)}) {
    const SplitInput input(mesh, tree, references);
    test::for_each_schedule([&](std::uint64_t seed) {
      SCOPED_TRACE("seed " + std::to_string(seed));
      expect_equal_counts(tree, references, input);
    });
  }
}

/// A leaf may have more pieces than any stack has room for.
TEST(DevicePackSplitOfManyPieces, SlowInALeafIsTheHosts) {
  const test::OwnedMesh mesh = test::giant_and_tiny(20, 13);
  const References references = split(mesh, 20'000);
  ASSERT_GT(references.size(), 2'000u);
  for (const BinaryTree& tree : {test::chain_tree(references), test::random_tree(references, 14)}) {
    const SplitInput input(mesh, tree, references);
    const auto expect_equal = [&]<class Calls>(Calls) {
      const auto model = test::with_dear_nodes(test::model_of_leaves<Calls>(Calls::kMaxLeaf));
      EXPECT_TRUE(packs_as_the_host<Calls>(input, mesh, tree, references, model));
    };
    expect_equal(test::Bvh2Calls{});
    expect_equal(test::Bvh8Calls{});
    expect_equal(test::CwbvhCalls{});
  }
}

TEST(DevicePackSplitOfLargeTrees, SlowWithNodesAboveTheCutIsTheHosts) {
  const test::OwnedMesh mesh = test::triangle_soup(6'000, 15);
  const References references = split(mesh, 30);
  for (const BinaryTree& tree : {build_lbvh(references), test::random_tree(references, 16)}) {
    for (const std::uint32_t leaf_limit : {1u, 8u}) {
      expect_equal_layouts(mesh, tree, references, leaf_limit);
    }
  }
}

TEST(DeviceFaceCounts, TakeAtMost36BytesAReferenceAndTheSort) {
  Carver faces, scratch, sort;
  carve_subtree_faces(faces, 1'000'000);
  carve_face_count_scratch(scratch, 1'000'000);
  carve_sort_scratch(sort, 1'000'000);
  EXPECT_LE(faces.peak(), 8'000'000u + 512u);
  EXPECT_LE(scratch.peak(), sort.peak() + 16'000'000u + 1024u);
}

}  // namespace
}  // namespace treelet::cuda
