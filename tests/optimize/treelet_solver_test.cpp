#include <treelet/optimize/treelet_solver.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "support/random.h"

namespace treelet {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// Builds every topology over a treelet's leaves, one after the other, by hanging the next leaf
/// beside every node of every smaller tree, and keeps the least cost. Each subtree counts as the
/// cheaper of an internal node and one leaf, as the packed layout will have it.
class Enumeration {
 public:
  Enumeration(const TreeletLeaves& leaves, const SahModel& sah) : leaves_(leaves), sah_(sah) {
    nodes_.reserve(2 * kMaxTreeletSize);  // links point into it
    for (int leaf = 0; leaf < leaves.size; ++leaf) nodes_.push_back({leaf, -1, -1});
    insert(1, 0);
  }

  float best_cost() const { return best_; }
  long topologies() const { return topologies_; }

 private:
  struct Node {
    int leaf, left, right;
  };
  struct Subtree {
    Aabb box;
    float cost;
    std::uint32_t count;
  };

  void insert(int leaf, int root) {
    if (leaf == leaves_.size) {
      ++topologies_;
      best_ = std::min(best_, evaluate(root).cost);
      return;
    }
    std::vector<int*> links{&root};
    collect_links(root, links);
    for (int* link : links) {
      const int below = *link, parent = int(nodes_.size());
      nodes_.push_back({-1, below, leaf});
      *link = parent;
      insert(leaf + 1, root);
      *link = below;
      nodes_.pop_back();
    }
  }

  void collect_links(int node, std::vector<int*>& links) {
    if (nodes_[std::size_t(node)].leaf >= 0) return;
    for (int* link : {&nodes_[std::size_t(node)].left, &nodes_[std::size_t(node)].right}) {
      links.push_back(link);
      collect_links(*link, links);
    }
  }

  Subtree evaluate(int index) const {
    const Node& node = nodes_[std::size_t(index)];
    if (node.leaf >= 0) {
      const std::size_t leaf = std::size_t(node.leaf);
      return {leaves_.box[leaf], leaves_.cost[leaf], leaves_.count[leaf]};
    }
    const Subtree left = evaluate(node.left), right = evaluate(node.right);
    const Aabb box = merge(left.box, right.box);
    const std::uint32_t count = left.count + right.count;
    const float area = half_area(box);
    const float internal = sah_.traversal_cost * area + (left.cost + right.cost);
    const float leaf =
        count <= sah_.leaf_limit ? sah_.intersection_cost * area * float(count) : kInfinity;
    return {box, std::min(internal, leaf), count};
  }

  const TreeletLeaves& leaves_;
  const SahModel& sah_;
  std::vector<Node> nodes_;
  float best_ = kInfinity;
  long topologies_ = 0;
};

/// Cost of the tree that `part` describes, recomputed from the leaves.
float cost_of_solution(const TreeletLeaves& leaves, const SahModel& sah,
                       const TreeletSolution& solution, std::uint32_t set, Aabb& box,
                       std::uint32_t& count) {
  if (std::has_single_bit(set)) {
    const std::size_t leaf = std::size_t(std::countr_zero(set));
    box = leaves.box[leaf];
    count = leaves.count[leaf];
    return leaves.cost[leaf];
  }
  const std::uint32_t part = solution.part(set);
  EXPECT_EQ(part & ~set, 0u);
  EXPECT_NE(part, 0u);
  EXPECT_NE(part, set);
  Aabb boxes[2];
  std::uint32_t counts[2];
  const float children = cost_of_solution(leaves, sah, solution, part, boxes[0], counts[0]) +
                         cost_of_solution(leaves, sah, solution, set ^ part, boxes[1], counts[1]);
  box = merge(boxes[0], boxes[1]);
  count = counts[0] + counts[1];
  return sah.subtree_cost(half_area(box), children, count);
}

enum class BoxKind { general, points, flat, equal };

Aabb random_box(test::Random& random, BoxKind kind) {
  const Vec3 lower = random.point(0.0f, 1.0f);
  switch (kind) {
    case BoxKind::points:
      return {lower, lower};
    case BoxKind::flat:
      return {{lower.x, lower.y, 0.5f},
              {lower.x + random.uniform(0.0f, 0.3f), lower.y + random.uniform(0.0f, 0.3f), 0.5f}};
    case BoxKind::equal:
      return {{0, 0, 0}, {1, 1, 1}};
    case BoxKind::general:
      break;
  }
  return {lower, lower + random.point(0.0f, 0.3f)};
}

TreeletLeaves random_leaves(test::Random& random, int size, BoxKind kind) {
  const bool only_references = random.below(3) == 0;
  TreeletLeaves leaves;
  leaves.size = size;
  for (std::size_t leaf = 0; leaf < std::size_t(size); ++leaf) {
    leaves.box[leaf] = random_box(random, kind);
    const std::uint64_t most = random.below(4) == 0 ? 40 : 3;
    leaves.count[leaf] = only_references ? 1 : std::uint32_t(1 + random.below(most));
    const float a_reference = half_area(leaves.box[leaf]);
    leaves.cost[leaf] = only_references
                            ? a_reference
                            : a_reference * random.uniform(0.5f, 4.0f) * float(leaves.count[leaf]);
  }
  return leaves;
}

void expect_optimal(const TreeletLeaves& leaves, const SahModel& sah) {
  TreeletSolution solution;
  solve_treelet(leaves, sah, solution);
  const std::uint32_t all = (1u << leaves.size) - 1;
  const Enumeration enumeration(leaves, sah);
  ASSERT_EQ(enumeration.topologies(), count_topologies(leaves.size));
  // The enumeration adds the same floats in the same tree, left and right swapped at most.
  EXPECT_EQ(solution.cost(all), enumeration.best_cost());

  Aabb box;
  std::uint32_t count = 0;
  EXPECT_EQ(cost_of_solution(leaves, sah, solution, all, box, count), solution.cost(all));
  EXPECT_EQ(box, solution.box(all));
  EXPECT_EQ(count, solution.count(all));
}

class TreeletSolver : public testing::TestWithParam<int> {};

TEST_P(TreeletSolver, FindsTheBestOfAllTopologies) {
  const int size = GetParam();
  const int repeats = size == 7 ? 4 : 25;
  for (const BoxKind kind : {BoxKind::general, BoxKind::points, BoxKind::flat, BoxKind::equal}) {
    for (const std::uint32_t leaf_limit : {1u, 2u, 8u, 64u}) {
      for (int repeat = 0; repeat < repeats; ++repeat) {
        const unsigned seed = unsigned(size * 1000 + repeat);
        SCOPED_TRACE("seed " + std::to_string(seed) + ", boxes " + std::to_string(int(kind)) +
                     ", leaf limit " + std::to_string(leaf_limit));
        test::Random random(seed);
        const TreeletLeaves leaves = random_leaves(random, size, kind);
        expect_optimal(leaves, {.leaf_limit = leaf_limit});
        if (HasFailure()) return;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Sizes, TreeletSolver, testing::Range(3, 8));

/// One triangle of cost 3 each, in the same place.
TreeletLeaves unit_cubes(int size) {
  TreeletLeaves leaves;
  leaves.size = size;
  leaves.box.fill({{0, 0, 0}, {1, 1, 1}});
  leaves.cost.fill(3.0f);
  leaves.count.fill(1);
  return leaves;
}

TEST(TreeletSolverByHand, JoinsNeighboursFirst) {
  // Two pairs of unit cubes far apart, given interleaved: a c b d.
  const auto cube = [](float x) { return Aabb{{x, 0, 0}, {x + 1, 1, 1}}; };
  TreeletLeaves leaves = unit_cubes(4);
  leaves.box = {cube(0), cube(100), cube(1), cube(101)};
  const SahModel sah{.leaf_limit = 1};
  TreeletSolution solution;
  solve_treelet(leaves, sah, solution);
  EXPECT_EQ(solution.part(0b1111), 0b1010u);
  const float pair = 1.2f * half_area({{0, 0, 0}, {2, 1, 1}}) + 6.0f;
  EXPECT_FLOAT_EQ(solution.cost(0b0101), pair);
  EXPECT_FLOAT_EQ(solution.cost(0b1111), 1.2f * half_area({{0, 0, 0}, {102, 1, 1}}) + 2.0f * pair);
}

TEST(TreeletSolverByHand, OfEqualCostsTheSmallestPartIsTaken) {
  const TreeletLeaves leaves = unit_cubes(5);
  TreeletSolution solution;
  solve_treelet(leaves, {.leaf_limit = 1}, solution);
  EXPECT_EQ(solution.part(0b11111), 0b00010u);  // all topologies cost the same
  EXPECT_EQ(solution.part(0b11010), 0b01000u);
}

TEST(TreeletSolverByHand, ASubsetMayBecomeOneLeaf) {
  const TreeletLeaves leaves = unit_cubes(4);
  TreeletSolution solution;
  solve_treelet(leaves, {.leaf_limit = 3}, solution);
  EXPECT_EQ(solution.cost(0b0111), 9.0f);  // three triangles in one box: no node pays
  EXPECT_FLOAT_EQ(solution.cost(0b1111), 1.2f * 3.0f + 12.0f);  // four do not fit
}

}  // namespace
}  // namespace treelet
