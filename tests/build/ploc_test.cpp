#include <treelet/build/ploc.h>

#include <gtest/gtest.h>

#include <treelet/build/lbvh.h>
#include <treelet/primitive/morton_order.h>
#include <treelet/tree/refit.h>

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "support/mesh_params.h"
#include "support/meshes.h"
#include "support/threads.h"
#include "support/trees.h"

namespace treelet {
namespace {

struct Cluster {
  Aabb box;
  std::string text;  // of the tree below, in brackets
};

/// The lane whose box merges best with that of lane i; of equal ones the first by exclusive or.
std::size_t nearest_by_definition(const std::vector<Cluster>& clusters, std::size_t i,
                                  std::size_t radius) {
  std::size_t nearest = i;
  float least = std::numeric_limits<float>::infinity();
  for (std::size_t k = 0; k < clusters.size(); ++k) {
    if (k == i || std::max(k, i) - std::min(k, i) > radius) continue;
    const float area = half_area(merge(clusters[i].box, clusters[k].box));
    const bool is_first = nearest == i || (k ^ i) < (nearest ^ i);
    if (area < least || (area == least && is_first)) {
      least = area;
      nearest = k;
    }
  }
  return nearest;
}

/// A round of [MeisterBittner2018], as it is written.
std::vector<Cluster> merge_by_definition(const std::vector<Cluster>& clusters, std::size_t radius) {
  std::vector<Cluster> next;
  for (std::size_t i = 0; i < clusters.size(); ++i) {
    const std::size_t other = nearest_by_definition(clusters, i, radius);
    const bool is_mutual = nearest_by_definition(clusters, other, radius) == i;
    if (!is_mutual) next.push_back(clusters[i]);
    if (!is_mutual || other < i) continue;
    next.push_back({merge(clusters[i].box, clusters[other].box),
                    "(" + clusters[i].text + " " + clusters[other].text + ")"});
  }
  return next;
}

std::string tree_by_definition(const References& references, std::size_t radius) {
  std::vector<Cluster> clusters;
  for (const std::uint32_t i : sort_along_morton_curve(references).references) {
    clusters.push_back({references.items[i].box(), std::to_string(i)});
  }
  while (clusters.size() > 1) clusters = merge_by_definition(clusters, radius);
  return clusters[0].text;
}

std::string text_of(const BinaryTree& tree, std::uint32_t slot) {
  const BinaryNode& node = tree.nodes[slot];
  if (node.is_leaf()) return std::to_string(node.index);
  return "(" + text_of(tree, node.left()) + " " + text_of(tree, node.right()) + ")";
}

TEST(Ploc, MergesAsDefined) {
  for (const int radius : {1, 3, 25}) {
    for (const test::OwnedMesh& mesh : {test::triangle_soup(300, 81), test::icosphere(1),
                                        test::identical_triangles(37), test::equal_centres(40)}) {
      const References references = create_references(mesh.view());
      const BinaryTree tree = build_ploc(references, {.radius = radius});
      EXPECT_EQ(text_of(tree, kRoot), tree_by_definition(references, std::size_t(radius)))
          << "radius " << radius;
    }
  }
}

class PlocOfHardMeshes : public testing::TestWithParam<test::NamedMesh> {};
INSTANTIATE_TEST_SUITE_P(Meshes, PlocOfHardMeshes, testing::ValuesIn(test::hard_meshes()),
                         test::mesh_name);

TEST_P(PlocOfHardMeshes, IsSound) {
  const References references = create_references(GetParam().mesh.view());
  for (const int radius : {1, 25, 100}) {
    EXPECT_TRUE(test::IsSound(build_ploc(references, {.radius = radius}), references)) << radius;
  }
}

// Boxes in boxes merge one by one: forty thousand rounds, were there no other way.
TEST(Ploc, DoesNotTakeARoundForEachOfNestedBoxes) {
  const References references = create_references(test::equal_centres(40'000).view());
  const BinaryTree tree = build_ploc(references);
  EXPECT_TRUE(test::IsSound(tree, references));
  EXPECT_LT(test::depth(tree), 1000u);
}

TEST(Ploc, IsBetterThanLbvh) {
  for (const test::OwnedMesh& mesh : {test::icosphere(4), test::triangle_soup(3000, 82)}) {
    const References references = create_references(mesh.view());
    EXPECT_LT(sah_cost(build_ploc(references), SahModel{}),
              sah_cost(build_lbvh(references), SahModel{}));
  }
}

// Enough clusters for several chunks of a list.
TEST(Ploc, DoesNotDependOnThreads) {
  const References references = create_references(test::triangle_soup(20'000, 83).view());
  const test::ThreadCountScope one(1);
  const BinaryTree expected = build_ploc(references);
  for (const unsigned threads : {2, 3, 5}) {
    const test::ThreadCountScope scope(threads);
    EXPECT_TRUE(test::equal_bytes(build_ploc(references), expected)) << threads << " threads";
  }
}

TEST(Ploc, RefusesBadRadii) {
  EXPECT_THROW(build_ploc({}, {.radius = 0}), std::invalid_argument);
  EXPECT_THROW(build_ploc({}, {.radius = 101}), std::invalid_argument);
}

}  // namespace
}  // namespace treelet
