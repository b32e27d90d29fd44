#include <treelet/build/hploc.h>

#include <gtest/gtest.h>
#include <treelet/build/hploc_steps.h>
#include <treelet/build/lbvh.h>
#include <treelet/build/lbvh_steps.h>
#include <treelet/optimize/treelet.h>
#include <treelet/primitive/morton_order.h>
#include <treelet/tree/refit.h>

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <iterator>
#include <limits>
#include <memory>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "support/errors.h"
#include "support/mesh_params.h"
#include "support/meshes.h"
#include "support/random.h"
#include "support/threads.h"
#include "support/trees.h"

namespace treelet {
namespace {

/// A cluster of the rule written out: a tree on the heap.
struct Cluster {
  Aabb box;
  std::uint32_t first, count, reference = 0;
  std::shared_ptr<Cluster> left, right;
};
using ClusterPointer = std::shared_ptr<Cluster>;
using Clusters = std::vector<ClusterPointer>;

/// The rule at the top of hploc_steps.h, from the root of the radix tree down, without slots.
class NaiveHploc {
 public:
  NaiveHploc(const References& references, int radius)
      : references_(references), order_(sort_along_morton_curve(references)), radius_(radius) {}

  ClusterPointer build() const { return clusters_of(0, std::int64_t(order_.size()) - 1)[0]; }

 private:
  Clusters clusters_of(std::int64_t first, std::int64_t last) const {
    if (first == last) return {leaf(std::uint32_t(first))};
    const RadixTreeView radix_tree{order_.codes};
    const std::int64_t split = radix_tree.find_split(first, last), count = last - first + 1;
    Clusters clusters = clusters_of(first, split);
    for (const ClusterPointer& right : clusters_of(split + 1, last)) clusters.push_back(right);
    const bool is_root = count == radix_tree.size();
    if (count <= 16 && !is_root) return clusters;
    while (clusters.size() > (is_root ? 1u : 16u)) clusters = merge_round(clusters);
    return clusters;
  }

  ClusterPointer leaf(std::uint32_t i) const {
    const std::uint32_t reference = order_.references[i];
    return std::make_shared<Cluster>(
        Cluster{references_.items[reference].box(), i, 1, reference, nullptr, nullptr});
  }

  std::size_t nearest_to(const Clusters& clusters, std::size_t i) const {
    std::vector<std::tuple<float, std::size_t, std::size_t>> candidates;
    for (std::size_t j = 0; j < clusters.size(); ++j) {
      if (j == i || std::abs(int(i) - int(j)) > radius_) continue;
      candidates.emplace_back(half_area(merge(clusters[i]->box, clusters[j]->box)), i ^ j, j);
    }
    return std::get<2>(*std::min_element(candidates.begin(), candidates.end()));
  }

  Clusters merge_round(const Clusters& clusters) const {
    Clusters next;
    for (std::size_t i = 0; i < clusters.size(); ++i) {
      const std::size_t j = nearest_to(clusters, i);
      const bool is_mutual = nearest_to(clusters, j) == i;
      if (is_mutual && j < i) continue;
      next.push_back(is_mutual ? merged(clusters[i], clusters[j]) : clusters[i]);
    }
    return next;
  }

  static ClusterPointer merged(const ClusterPointer& left, const ClusterPointer& right) {
    return std::make_shared<Cluster>(Cluster{merge(left->box, right->box), left->first,
                                             left->count + right->count, 0, left, right});
  }

  const References& references_;
  MortonOrder order_;
  int radius_;
};

/// Every node, and that children lie in the pair numbered by the first reference of the right one.
void expect_equal(const BinaryTree& tree, std::uint32_t slot, const Cluster& expected) {
  const BinaryNode& node = tree.nodes[slot];
  ASSERT_EQ(node.count, expected.count) << "slot " << slot;
  ASSERT_EQ(node.box(), expected.box) << "slot " << slot;
  ASSERT_EQ(node.index, expected.left ? 2 * expected.right->first : expected.reference)
      << "slot " << slot;
  if (!expected.left) return;
  expect_equal(tree, node.left(), *expected.left);
  expect_equal(tree, node.right(), *expected.right);
}

void expect_naive_tree(const References& references, int radius) {
  SCOPED_TRACE(std::to_string(references.size()) + " references, radius " + std::to_string(radius));
  const BinaryTree tree = build_hploc(references, {.radius = radius});
  ASSERT_TRUE(test::IsSound(tree, references));
  if (!tree.empty()) expect_equal(tree, kRoot, *NaiveHploc(references, radius).build());
}

class HplocOfHardMeshes : public testing::TestWithParam<test::NamedMesh> {};
INSTANTIATE_TEST_SUITE_P(Meshes, HplocOfHardMeshes, testing::ValuesIn(test::hard_meshes()),
                         test::mesh_name);

TEST_P(HplocOfHardMeshes, FollowsTheRule) {
  const References references = create_references(GetParam().mesh.view());
  for (const int radius : {1, 2, 8, 16}) expect_naive_tree(references, radius);
}

TEST(Hploc, FollowsTheRuleForEverySmallCount) {
  for (std::size_t count = 1; count < 70; ++count) {
    expect_naive_tree(create_references(test::triangle_soup(count, 200 + count).view()), 8);
    expect_naive_tree(create_references(test::equal_centres(count).view()), 8);
    expect_naive_tree(create_references(test::identical_triangles(count).view()), 8);
    if (HasFailure()) return;
  }
}

// More references than a task takes, so that the top is merged after its subtrees.
TEST(Hploc, FollowsTheRuleAcrossTasks) {
  for (const int radius : {3, 8}) {
    expect_naive_tree(create_references(test::triangle_soup(12'000, 201).view()), radius);
  }
}

using Indices = std::vector<std::uint32_t>;

/// The references below each node.
std::set<Indices> all_groups(const BinaryTree& tree) {
  std::set<Indices> groups;
  for (std::uint32_t slot = 0; slot < tree.nodes.size(); ++slot) {
    if (slot == 1) continue;
    Indices group = test::references_below(tree, slot);
    std::sort(group.begin(), group.end());
    groups.insert(group);
  }
  return groups;
}

Aabb box_of(const References& references, const Indices& group) {
  Aabb box = Aabb::empty();
  for (const std::uint32_t i : group) box = merge(box, references.items[i].box());
  return box;
}

/// The same of agglomerative clustering: the one best pair of all, again and again.
std::set<Indices> groups_of_best_pairs(const References& references) {
  std::vector<Indices> clusters;
  for (std::uint32_t i = 0; i < references.size(); ++i) clusters.push_back({i});
  std::set<Indices> groups(clusters.begin(), clusters.end());
  while (clusters.size() > 1) {
    std::tuple<float, Indices> best{std::numeric_limits<float>::infinity(), {}};
    for (const Indices& a : clusters) {
      for (const Indices& b : clusters) {
        if (&a == &b) continue;
        Indices both;
        std::merge(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(both));
        best = std::min(best, {half_area(box_of(references, both)), both});
      }
    }
    const Indices& merged = std::get<1>(best);
    std::erase_if(clusters, [&](const Indices& cluster) {
      return std::includes(merged.begin(), merged.end(), cluster.begin(), cluster.end());
    });
    clusters.push_back(merged);
    groups.insert(merged);
  }
  return groups;
}

// Growing a box never makes its merged boxes smaller: mutual neighbours may be merged at once.
TEST(Hploc, OfFewReferencesIsAgglomerativeClustering) {
  for (std::uint64_t seed = 210; seed < 240; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    test::Random random(seed);
    std::vector<Aabb> boxes;
    for (std::uint64_t count = 2 + random.below(15); boxes.size() < count;) {
      const Vec3 lower = random.point(0.0f, 1.0f);
      boxes.push_back({lower, lower + random.point(0.0f, 0.05f)});
    }
    const References references = test::references_of(boxes);
    const BinaryTree tree = build_hploc(references, {.radius = 16});
    ASSERT_EQ(all_groups(tree), groups_of_best_pairs(references));
  }
}

TEST(Hploc, HalvesIdenticalBoxes) {
  for (const std::size_t count : {2, 4, 16, 32, 64, 1024, 4096, 16384}) {
    const References references = create_references(test::identical_triangles(count).view());
    EXPECT_EQ(test::depth(build_hploc(references)), std::bit_width(count - 1)) << count;
  }
}

// A round a merge is the worst there is: nested boxes, of which only the two inner ones are mutual.
// Time in proportion to the square of the count would take hours.
TEST(Hploc, SlowOfAMillionEqualCodesIsSound) {
  const References nested = create_references(test::equal_centres(1'000'000).view());
  const BinaryTree tree = build_hploc(nested);
  EXPECT_TRUE(test::IsSound(tree, nested));
  EXPECT_LE(test::depth(tree), 20u * (kHplocLanes - 1));
  const References identical = create_references(test::identical_triangles(1'000'000).view());
  const BinaryTree balanced = build_hploc(identical);
  EXPECT_TRUE(test::IsSound(balanced, identical));
  EXPECT_LE(test::depth(balanced), 21u);
}

double sah_of(const BinaryTree& tree) { return sah_cost(tree, SahModel{}); }

/// SAH over the LBVH's.
double cost_over_lbvh(const test::OwnedMesh& mesh) {
  const References references = create_references(mesh.view());
  return sah_of(build_hploc(references)) / sah_of(build_lbvh(references));
}

// Greedy clustering promises nothing: the bounds are what was measured and a little.
TEST(Hploc, IsBetterThanLbvh) {
  EXPECT_LT(cost_over_lbvh(test::icosphere(4)), 0.97);
  EXPECT_LT(cost_over_lbvh(test::triangle_soup(3000, 241)), 0.95);
  EXPECT_LT(cost_over_lbvh(test::slivers(3000, 242)), 0.92);
  EXPECT_LT(cost_over_lbvh(test::giant_and_tiny(3000, 243)), 0.2);
}

// Where the LBVH is optimal and all neighbours are equally near.
TEST(Hploc, OfARegularGridIsNotFarFromLbvh) {
  EXPECT_DOUBLE_EQ(cost_over_lbvh(test::coplanar_grid(32)), 1.0);
  EXPECT_LT(cost_over_lbvh(test::coplanar_grid(40)), 1.25);
}

TEST(Hploc, TreeletsStillImproveIt) {
  for (const test::OwnedMesh& mesh :
       {test::icosphere(4), test::triangle_soup(3000, 241), test::slivers(3000, 242)}) {
    const References references = create_references(mesh.view());
    BinaryTree tree = build_hploc(references);
    const double before = sah_of(tree);
    restructure_treelets(tree, SahModel{}, {});
    EXPECT_TRUE(test::IsSound(tree, references));
    EXPECT_LT(sah_of(tree), 0.99 * before);
  }
}

TEST(Hploc, ALargerRadiusIsBetter) {
  const References references = create_references(test::triangle_soup(20'000, 249).view());
  const auto cost = [&](int radius) { return sah_of(build_hploc(references, {.radius = radius})); };
  EXPECT_LT(cost(4), cost(1));
  EXPECT_LT(cost(8), cost(2));
  EXPECT_EQ(cost(8), sah_of(build_hploc(references)));
}

TEST(Hploc, RefusesARadiusOutOfRange) {
  const References none = create_references(test::empty_mesh().view());
  for (const int radius : {-1, 0, 17}) {
    EXPECT_EQ(test::error_of([&] { build_hploc(none, {.radius = radius}); }),
              "the radius is from 1 to 16, not " + std::to_string(radius));
  }
}

TEST(Hploc, DoesNotDependOnTheOrderOfTrianglesWhereCodesDiffer) {
  const test::OwnedMesh mesh = test::triangle_soup(3000, 244);
  const References references = create_references(mesh.view());
  const MortonOrder order = sort_along_morton_curve(references);
  ASSERT_EQ(std::adjacent_find(order.codes.begin(), order.codes.end()), order.codes.end());
  const double expected = sah_of(build_hploc(references));
  for (const std::uint64_t seed : {245, 246, 247}) {
    const References permuted = create_references(test::permuted(mesh, seed).view());
    EXPECT_EQ(sah_of(build_hploc(permuted)), expected) << "seed " << seed;
  }
}

TEST(Hploc, DoesNotDependOnThreads) {
  const References references = create_references(test::triangle_soup(20'000, 248).view());
  const test::ThreadCountScope one(1);
  const BinaryTree expected = build_hploc(references);
  ASSERT_TRUE(test::IsSound(expected, references));
  for (const unsigned threads : {2, 3, 5}) {
    const test::ThreadCountScope scope(threads);
    EXPECT_TRUE(test::equal_bytes(build_hploc(references), expected)) << threads << " threads";
  }
}

}  // namespace
}  // namespace treelet
