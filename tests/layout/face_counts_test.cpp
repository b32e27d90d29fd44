#include <treelet/layout/face_counts.h>

#include <gtest/gtest.h>

#include <treelet/build/lbvh.h>
#include <treelet/primitive/split.h>

#include <set>
#include <string>

#include "support/meshes.h"
#include "support/random.h"
#include "support/threads.h"
#include "support/trees.h"

namespace treelet {
namespace {

void expect_counts(const BinaryTree& tree, const References& references) {
  const FaceCounts counts(tree, references);
  for (std::uint32_t slot = 0; slot < tree.nodes.size(); ++slot) {
    if (slot == 1) continue;  // unused
    std::set<std::uint32_t> faces;
    for (const std::uint32_t i : test::references_below(tree, slot)) {
      faces.insert(references.items[i].face);
    }
    ASSERT_EQ(counts[slot], faces.size()) << "slot " << slot;
  }
}

TEST(FaceCounts, CountEachFaceOnceASubtree) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    test::Random random(seed);
    References references = test::references_of(std::vector<Aabb>(200, {{0, 0, 0}, {1, 1, 1}}));
    references.may_repeat_faces = true;
    std::uint32_t face = 0;
    for (Reference& item : references.items) item.face = face += random.below(3) == 0;
    expect_counts(test::random_tree(references, seed), references);
    expect_counts(test::chain_tree(references), references);
  }
}

TEST(FaceCounts, OfSplitMeshes) {
  for (const auto& [name, mesh] : test::hard_meshes()) {
    SCOPED_TRACE(name);
    References references = create_references(mesh.view());
    split_references(references, mesh.view(), references.size());
    if (references.size() > 1200) continue;  // the oracle is quadratic
    expect_counts(build_lbvh(references), references);
  }
}

TEST(FaceCounts, AreThoseOfReferencesWhereNothingIsRepeated) {
  const test::OwnedMesh mesh = test::triangle_soup(300, 1);
  const References references = create_references(mesh.view());
  const BinaryTree tree = build_lbvh(references);
  const FaceCounts counts(tree, references);
  for (std::uint32_t slot = 2; slot < tree.nodes.size(); ++slot) {
    ASSERT_EQ(counts[slot], tree.nodes[slot].count);
  }
}

TEST(FaceCounts, AreTheSameForAnyNumberOfThreads) {
  const test::OwnedMesh mesh = test::triangle_soup(20000, 2);  // several subtrees below the cut
  References references = create_references(mesh.view());
  split_references(references, mesh.view(), 20000);
  const BinaryTree tree = build_lbvh(references);
  const FaceCounts expected(tree, references);
  for (const unsigned threads : {1u, 2u, 3u, 7u}) {
    const test::ThreadCountScope scope(threads);
    const FaceCounts counts(tree, references);
    for (std::uint32_t slot = 2; slot < tree.nodes.size(); ++slot) {
      ASSERT_EQ(counts[slot], expected[slot]) << threads << " threads";
    }
  }
}

}  // namespace
}  // namespace treelet
