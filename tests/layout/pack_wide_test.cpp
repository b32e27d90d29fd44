// What the packers of both wide layouts promise, pack_bvh8 and pack_cwbvh.

#include <gtest/gtest.h>

#include <treelet/build/lbvh.h>
#include <treelet/layout/epo.h>
#include <treelet/layout/pack_bvh8.h>
#include <treelet/layout/pack_cwbvh.h>
#include <treelet/layout/statistics.h>
#include <treelet/layout/validate_layout.h>
#include <treelet/primitive/split.h>

#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "support/layouts.h"
#include "support/meshes.h"
#include "support/threads.h"
#include "support/trees.h"

namespace treelet {
namespace {

using Sentences = std::vector<std::string>;

struct Bvh8Packer {
  using Model = WideCostModel;
  static constexpr auto pack = pack_bvh8;
  static constexpr std::uint32_t kMaxLeaf = 16;
};
struct CwbvhPacker {
  using Model = CwbvhCostModel;
  static constexpr auto pack = pack_cwbvh;
  static constexpr std::uint32_t kMaxLeaf = CwbvhNode::kMaxLeaf;
};

template <class Packer>
class PackWide : public testing::Test {
 protected:
  using Model = typename Packer::Model;

  static auto pack(const test::OwnedMesh& mesh, const BinaryTree& tree,
                   const References& references, const Model& model = {}) {
    return Packer::pack(tree, references, mesh.view(), model);
  }
  static auto pack(const test::OwnedMesh& mesh, const References& references) {
    return pack(mesh, build_lbvh(references), references);
  }
  static auto pack(const test::OwnedMesh& mesh, const Model& model = {}) {
    const References references = create_references(mesh.view());
    return pack(mesh, build_lbvh(references), references, model);
  }
};
using Packers = testing::Types<Bvh8Packer, CwbvhPacker>;
TYPED_TEST_SUITE(PackWide, Packers);

TYPED_TEST(PackWide, IsSoundOnEveryHardMesh) {
  for (const auto& [name, mesh] : test::hard_meshes()) {
    const References references = create_references(mesh.view());
    for (const std::uint32_t leaf_limit : {1u, 2u, 3u, 8u, 16u}) {
      if (leaf_limit > TypeParam::kMaxLeaf) continue;
      for (const BinaryTree& tree : {test::random_tree(references, 3), build_lbvh(references)}) {
        SCOPED_TRACE(name + ", leaf limit " + std::to_string(leaf_limit) + ", seed 3");
        const auto bvh = this->pack(mesh, tree, references, {.leaf_limit = leaf_limit});
        EXPECT_EQ(validate(bvh, mesh.view()), Sentences{});
        EXPECT_EQ(test::triangle_count(bvh), references.size());
        EXPECT_LE(compute_statistics(bvh, {}).leaf_histogram.size(), leaf_limit + 1);
      }
    }
  }
}

TYPED_TEST(PackWide, IsSoundOverSplitTriangles) {
  for (const auto& [name, mesh] : test::hard_meshes()) {
    SCOPED_TRACE(name);
    References references = create_references(mesh.view());
    split_references(references, mesh.view(), references.size());
    EXPECT_EQ(validate(this->pack(mesh, references), mesh.view()), Sentences{});
  }
}

TYPED_TEST(PackWide, OfAChainIsSound) {
  const test::OwnedMesh mesh = test::triangle_soup(6000, 9);
  const References references = create_references(mesh.view());
  const auto bvh = this->pack(mesh, test::chain_tree(references), references);
  EXPECT_EQ(validate(bvh, mesh.view()), Sentences{});
}

TYPED_TEST(PackWide, AnEmptyMeshHasNoNodes) {
  const auto bvh = this->pack(test::empty_mesh());
  EXPECT_TRUE(bvh.nodes.empty());
  EXPECT_TRUE(bvh.bounds.is_empty());
  EXPECT_EQ(bvh.bytes(), 0u);
}

TYPED_TEST(PackWide, KeepsEachFaceOnceInALeafThatHoldsItTwice) {
  const test::OwnedMesh mesh = test::two_triangles();
  References references = create_references(mesh.view());
  Array<Reference> repeated(4);
  for (std::size_t i = 0; i < 4; ++i) repeated[i] = references.items[i / 2];
  references.items = std::move(repeated);
  references.may_repeat_faces = true;
  const auto bvh = this->pack(mesh, references);
  EXPECT_EQ(test::triangle_count(bvh), 2u);
  EXPECT_EQ(validate(bvh, mesh.view()), Sentences{});  // so both are there
}

TYPED_TEST(PackWide, GivesTheSameBytesForAnyNumberOfThreads) {
  const test::OwnedMesh mesh = test::triangle_soup(30000, 8);  // several parts below the cut
  const auto expected = this->pack(mesh);
  EXPECT_EQ(validate(expected, mesh.view()), Sentences{});
  for (const unsigned threads : {1u, 2u, 3u, 7u}) {
    const test::ThreadCountScope scope(threads);
    EXPECT_TRUE(test::equal_bytes(this->pack(mesh), expected));
  }
}

TYPED_TEST(PackWide, RefusesLeavesThatItsNodesCannotName) {
  for (const std::uint32_t leaf_limit : {0u, TypeParam::kMaxLeaf + 1}) {
    EXPECT_THROW(this->pack(test::one_triangle(), {.leaf_limit = leaf_limit}),
                 std::invalid_argument);
  }
}

TYPED_TEST(PackWide, SeparatedTrianglesHaveNoEpo) {
  test::OwnedMesh apart;
  for (int i = 0; i < 64; ++i) {
    const float x = float(3 * i);
    apart.add({x, 0, 0}, {x + 1, 0, 0}, {x, 1, 0});
  }
  EXPECT_EQ(compute_epo(this->pack(apart, {.leaf_limit = 1}), {}), 0.0);
}

}  // namespace
}  // namespace treelet
