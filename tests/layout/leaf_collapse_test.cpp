#include <treelet/layout/leaf_collapse.h>

#include <gtest/gtest.h>

#include <treelet/build/lbvh.h>
#include <treelet/tree/refit.h>

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "support/meshes.h"
#include "support/random.h"
#include "support/trees.h"

namespace treelet {
namespace {

/// The collapse as its definition says it, top-down and with every quantity recomputed.
class Oracle {
 public:
  Oracle(const BinaryTree& tree, const References& references, const SahModel& sah)
      : tree_(tree), references_(references), sah_(sah) {}

  std::set<std::uint32_t> faces(std::uint32_t slot) const {
    const BinaryNode& node = tree_.nodes[slot];
    if (node.is_leaf()) return {references_.items[node.index].face};
    std::set<std::uint32_t> all = faces(node.left());
    all.merge(faces(node.right()));
    return all;
  }

  float leaf_cost(std::uint32_t slot) const {
    const std::size_t triangles = faces(slot).size();
    const float area = half_area(tree_.nodes[slot].box());
    if (triangles > sah_.leaf_limit) return std::numeric_limits<float>::infinity();
    return sah_.intersection_cost * area * float(triangles);
  }

  float internal_cost(std::uint32_t slot) const {
    const BinaryNode& node = tree_.nodes[slot];
    if (node.is_leaf()) return std::numeric_limits<float>::infinity();
    return sah_.traversal_cost * half_area(node.box()) + (cost(node.left()) + cost(node.right()));
  }

  float cost(std::uint32_t slot) const { return std::min(internal_cost(slot), leaf_cost(slot)); }

  bool is_leaf(std::uint32_t slot) const { return leaf_cost(slot) <= internal_cost(slot); }

 private:
  const BinaryTree& tree_;
  const References& references_;
  const SahModel& sah_;
};

struct Totals {
  std::uint32_t nodes = 0, triangles = 0;
};

/// Compares every slot that stays reachable; returns what the subtree takes.
Totals expect_equal_below(const BinaryTree& tree, const LeafCollapse& collapse,
                          const Oracle& oracle, std::uint32_t slot) {
  Totals totals;
  EXPECT_EQ(collapse.is_leaf[slot] != 0, oracle.is_leaf(slot)) << "slot " << slot;
  if (oracle.is_leaf(slot)) {
    totals = {0, std::uint32_t(oracle.faces(slot).size())};
  } else {
    const Totals left = expect_equal_below(tree, collapse, oracle, tree.nodes[slot].left());
    const Totals right = expect_equal_below(tree, collapse, oracle, tree.nodes[slot].right());
    totals = {1 + left.nodes + right.nodes, left.triangles + right.triangles};
  }
  EXPECT_EQ(collapse.node_count[slot], totals.nodes) << "slot " << slot;
  EXPECT_EQ(collapse.triangle_count[slot], totals.triangles) << "slot " << slot;
  return totals;
}

void expect_equals_oracle(const BinaryTree& tree, const References& references,
                          const SahModel& sah) {
  if (tree.empty()) return;
  const LeafCollapse collapse = collapse_leaves(tree, references, sah);
  const Oracle oracle(tree, references, sah);
  expect_equal_below(tree, collapse, oracle, kRoot);
  const double root_area = half_area(tree.nodes[kRoot].box());
  const double expected = root_area > 0.0 ? oracle.cost(kRoot) / root_area : 0.0;
  EXPECT_EQ(collapsed_sah_cost(tree, references, sah), expected);
}

TEST(LeafCollapse, EqualsItsDefinition) {
  for (const test::NamedMesh& named : test::hard_meshes()) {
    for (const std::uint32_t leaf_limit : {1u, 2u, 8u, 64u}) {
      SCOPED_TRACE(named.name + ", leaf limit " + std::to_string(leaf_limit));
      References references = create_references(named.mesh.view());
      if (references.size() > 300) continue;  // the oracle is quadratic
      const SahModel sah{.leaf_limit = leaf_limit};
      expect_equals_oracle(build_lbvh(references), references, sah);
      expect_equals_oracle(test::random_tree(references, 1), references, sah);
    }
  }
}

References with_repeated_faces(std::size_t count, std::uint32_t faces, std::uint64_t seed) {
  test::Random random(seed);
  std::vector<Aabb> boxes;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 lower = random.point(0.0f, 1.0f);
    boxes.push_back({lower, lower + random.point(0.0f, 0.6f)});
  }
  References references = test::references_of(boxes);
  references.may_repeat_faces = true;
  std::vector<std::uint32_t> numbers;
  for (std::size_t i = 0; i < count; ++i) numbers.push_back(std::uint32_t(random.below(faces)));
  std::sort(numbers.begin(), numbers.end());
  for (std::size_t i = 0; i < count; ++i) references.items[i].face = numbers[i];
  return references;
}

TEST(LeafCollapse, CountsARepeatedFaceOnceALeaf) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const References references = with_repeated_faces(60, 8, seed);
    for (const std::uint32_t leaf_limit : {1u, 4u, 16u, 64u}) {
      expect_equals_oracle(test::random_tree(references, seed), references,
                           {.leaf_limit = leaf_limit});
    }
  }
}

TEST(LeafCollapse, FourPiecesOfAFaceAreOneTriangle) {
  References references = test::references_of(std::vector<Aabb>(4, {{0, 0, 0}, {1, 1, 1}}));
  references.may_repeat_faces = true;
  for (Reference& item : references.items) item.face = 9;
  const BinaryTree tree = test::chain_tree(references);
  const LeafCollapse collapse = collapse_leaves(tree, references, {});
  EXPECT_TRUE(collapse.is_leaf[kRoot]);
  EXPECT_EQ(collapse.triangle_count[kRoot], 1u);
}

TEST(LeafCollapse, PiecesOfAFaceDoNotCountAgainstTheLeafLimit) {
  References references = test::references_of(std::vector<Aabb>(100, {{0, 0, 0}, {1, 1, 1}}));
  references.may_repeat_faces = true;
  for (std::size_t i = 0; i < 100; ++i) references.items[i].face = i < 60 ? 3 : 4;
  const LeafCollapse collapse =
      collapse_leaves(test::random_tree(references, 1), references, {.leaf_limit = 2});
  EXPECT_TRUE(collapse.is_leaf[kRoot]);
  EXPECT_EQ(collapse.triangle_count[kRoot], 2u);
}

TEST(LeafCollapse, RespectsTheLeafLimit) {
  const References references = test::references_of(std::vector<Aabb>(64, {{0, 0, 0}, {1, 1, 1}}));
  const BinaryTree tree = test::random_tree(references, 2);
  for (const std::uint32_t leaf_limit : {1u, 3u, 8u, 63u, 64u}) {
    const LeafCollapse collapse = collapse_leaves(tree, references, {.leaf_limit = leaf_limit});
    EXPECT_EQ(collapse.is_leaf[kRoot] != 0, leaf_limit >= 64);
    for (std::uint32_t slot = 2; slot < tree.nodes.size(); ++slot) {
      EXPECT_EQ(collapse.is_leaf[slot] != 0, tree.nodes[slot].count <= leaf_limit);
    }
  }
}

TEST(LeafCollapse, ATieBecomesALeaf) {
  // No area: a leaf and a node cost the same, nothing.
  const References references = test::references_of(std::vector<Aabb>(2, {{1, 2, 3}, {1, 2, 3}}));
  const LeafCollapse collapse = collapse_leaves(test::chain_tree(references), references, {});
  EXPECT_TRUE(collapse.is_leaf[kRoot]);
}

TEST(LeafFaces, ListsFacesLeftToRightEachOnce) {
  References references = test::references_of(std::vector<Aabb>(5, {{0, 0, 0}, {1, 1, 1}}));
  references.may_repeat_faces = true;
  const std::uint32_t faces[] = {4, 2, 4, 9, 2};
  for (std::size_t i = 0; i < 5; ++i) references.items[i].face = faces[i];
  const BinaryTree tree = test::balanced_tree(references, {3, 0, 1, 2, 4});
  LeafFaces leaf_faces(tree, references);
  const auto collect = [&](std::uint32_t slot) {
    const auto span = leaf_faces.collect(slot);
    return std::vector<std::uint32_t>(span.begin(), span.end());
  };
  EXPECT_EQ(collect(kRoot), (std::vector<std::uint32_t>{9, 4, 2}));
  EXPECT_EQ(collect(tree.nodes[kRoot].right()), (std::vector<std::uint32_t>{2, 4}));
  EXPECT_EQ(collect(kRoot), (std::vector<std::uint32_t>{9, 4, 2}));
}

}  // namespace
}  // namespace treelet
