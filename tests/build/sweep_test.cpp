#include <treelet/build/sweep.h>

#include <gtest/gtest.h>
#include <treelet/build/lbvh.h>
#include <treelet/tree/refit.h>

#include <algorithm>
#include <bit>
#include <limits>
#include <set>

#include "support/mesh_params.h"
#include "support/meshes.h"
#include "support/threads.h"
#include "support/trees.h"

namespace treelet {
namespace {

using Indices = std::vector<std::uint32_t>;

double cost_of_side(const References& references, const Indices& side) {
  Aabb box = Aabb::empty();
  for (const std::uint32_t i : side) box = merge(box, references.items[i].box());
  return double(half_area(box)) * double(side.size());
}

struct BestSplit {
  double cost = std::numeric_limits<double>::infinity();
  std::size_t larger_side = 0;
};

/// The cheapest split of all along all axes, of equal ones the most balanced.
BestSplit best_split_by_trying_all(const References& references, Indices indices) {
  BestSplit best;
  for (int axis = 0; axis < 3; ++axis) {
    std::sort(indices.begin(), indices.end(), [&](std::uint32_t a, std::uint32_t b) {
      const float centre_a = doubled_centroid(references.items[a].box())[axis];
      const float centre_b = doubled_centroid(references.items[b].box())[axis];
      return centre_a != centre_b ? centre_a < centre_b : a < b;
    });
    for (auto middle = indices.begin() + 1; middle != indices.end(); ++middle) {
      const Indices left(indices.begin(), middle), right(middle, indices.end());
      const double cost = cost_of_side(references, left) + cost_of_side(references, right);
      const std::size_t larger_side = std::max(left.size(), right.size());
      if (cost < best.cost || (cost == best.cost && larger_side < best.larger_side)) {
        best = {cost, larger_side};
      }
    }
  }
  return best;
}

/// Checks each split of the tree against all that there are.
void expect_best_splits(const BinaryTree& tree, const References& references) {
  for (std::uint32_t slot = 0; slot < tree.nodes.size(); ++slot) {
    const BinaryNode& node = tree.nodes[slot];
    if (slot == 1 || node.is_leaf()) continue;
    const Indices left = test::references_below(tree, node.left());
    const Indices right = test::references_below(tree, node.right());
    const BestSplit best = best_split_by_trying_all(references, test::references_below(tree, slot));
    ASSERT_EQ(cost_of_side(references, left) + cost_of_side(references, right), best.cost)
        << "slot " << slot;
    ASSERT_EQ(std::max(left.size(), right.size()), best.larger_side) << "slot " << slot;
  }
}

class SweepOfHardMeshes : public testing::TestWithParam<test::NamedMesh> {};
INSTANTIATE_TEST_SUITE_P(Meshes, SweepOfHardMeshes, testing::ValuesIn(test::hard_meshes()),
                         test::mesh_name);

TEST_P(SweepOfHardMeshes, IsSound) {
  const References references = create_references(GetParam().mesh.view());
  EXPECT_TRUE(test::IsSound(build_sweep(references), references));
}

TEST_P(SweepOfHardMeshes, TakesTheBestSplitEverywhere) {
  test::OwnedMesh mesh = GetParam().mesh;
  mesh.faces.resize(std::min<std::size_t>(mesh.faces.size(), 50));
  const References references = create_references(mesh.view());
  expect_best_splits(build_sweep(references), references);
}

TEST(Sweep, HalvesIdenticalBoxes) {
  for (const std::size_t count : {2, 3, 50, 1000, 1024, 1025}) {
    const References references = create_references(test::identical_triangles(count).view());
    EXPECT_EQ(test::depth(build_sweep(references)), std::bit_width(count - 1)) << count;
  }
}

TEST(Sweep, TakesMinusZeroForZero) {
  std::vector<Aabb> boxes;
  for (const float zero : {0.0f, -0.0f, 0.0f, -0.0f}) boxes.push_back({{zero, 0, 0}, {zero, 1, 1}});
  const BinaryTree tree = build_sweep(test::references_of(boxes));
  EXPECT_EQ(test::references_below(tree, kRoot), (Indices{0, 1, 2, 3}));
}

TEST(Sweep, SplitsAcrossTheGapAlongEachAxis) {
  for (int axis = 0; axis < 3; ++axis) {
    test::OwnedMesh mesh;
    for (int i = 0; i < 10; ++i) {
      const float along = float(i) * 0.01f + (i % 2 == 0 ? 0.0f : 10.0f);
      const Vec3 p{axis == 0 ? along : 0, axis == 1 ? along : 0, axis == 2 ? along : 0};
      mesh.add(p, p + Vec3{1, 0, 1}, p + Vec3{0, 1, 0});
    }
    const References references = create_references(mesh.view());
    const BinaryTree tree = build_sweep(references);
    Indices left = test::references_below(tree, tree.nodes[kRoot].left());
    std::sort(left.begin(), left.end());
    EXPECT_EQ(left, (Indices{0, 2, 4, 6, 8})) << "axis " << axis;
  }
}

TEST(Sweep, IsBetterThanLbvh) {
  for (const test::OwnedMesh& mesh :
       {test::icosphere(4), test::triangle_soup(3000, 121), test::giant_and_tiny(3000, 122)}) {
    const References references = create_references(mesh.view());
    EXPECT_LT(sah_cost(build_sweep(references), SahModel{}),
              sah_cost(build_lbvh(references), SahModel{}));
  }
}

bool centroids_differ(const References& references) {
  for (int axis = 0; axis < 3; ++axis) {
    std::set<float> centroids;
    for (const Reference& reference : references.items) {
      centroids.insert(doubled_centroid(reference.box())[axis]);
    }
    if (centroids.size() != references.size()) return false;
  }
  return true;
}

TEST(Sweep, DoesNotDependOnTheOrderOfTrianglesWhereCentroidsDiffer) {
  const test::OwnedMesh mesh = test::triangle_soup(500, 123);
  const References references = create_references(mesh.view());
  ASSERT_TRUE(centroids_differ(references));
  const double expected = sah_cost(build_sweep(references), SahModel{});
  for (const std::uint64_t seed : {124, 125, 126}) {
    const References permuted = create_references(test::permuted(mesh, seed).view());
    EXPECT_EQ(sah_cost(build_sweep(permuted), SahModel{}), expected) << "seed " << seed;
  }
}

// Enough triangles for levels that threads share: ranges above 4096 references.
TEST(Sweep, DoesNotDependOnThreads) {
  const References references = create_references(test::triangle_soup(20'000, 127).view());
  const test::ThreadCountScope one(1);
  const BinaryTree expected = build_sweep(references);
  ASSERT_TRUE(test::IsSound(expected, references));
  for (const unsigned threads : {2, 3, 5}) {
    const test::ThreadCountScope scope(threads);
    EXPECT_TRUE(test::equal_bytes(build_sweep(references), expected)) << threads << " threads";
  }
}

}  // namespace
}  // namespace treelet
