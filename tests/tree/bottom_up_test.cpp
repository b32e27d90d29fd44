#include <treelet/tree/bottom_up.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <utility>

#include "support/meshes.h"
#include "support/threads.h"
#include "support/trees.h"

namespace treelet {
namespace {

/// Trees whose cuts differ: many subtrees, a chain of top nodes, one subtree, one leaf, none.
std::vector<BinaryTree> sample_trees() {
  const References many = create_references(test::triangle_soup(20'000, 81).view());
  const References few = create_references(test::triangle_soup(500, 82).view());
  const References one = create_references(test::one_triangle().view());
  std::vector<BinaryTree> trees;
  trees.push_back(test::random_tree(many, 83));
  trees.push_back(test::chain_tree(many));
  trees.push_back(test::random_tree(few, 84));
  trees.push_back(test::balanced_tree(one));
  trees.emplace_back();
  return trees;
}

std::vector<std::uint32_t> all_internal_nodes(const BinaryTree& tree) {
  std::vector<std::uint32_t> nodes;
  for (std::uint32_t slot = 0; slot < tree.nodes.size(); ++slot) {
    if (slot != 1 && !tree.nodes[slot].is_leaf()) nodes.push_back(slot);
  }
  return nodes;
}

TEST(CutTree, HasAllLargeNodesOnTopParentsFirst) {
  for (const BinaryTree& tree : sample_trees()) {
    const TreeCut cut = cut_tree(tree);
    std::vector<bool> is_due(tree.nodes.size(), false);
    if (!tree.empty()) is_due[kRoot] = true;
    for (const std::uint32_t slot : cut.top) {
      ASSERT_GT(tree.nodes[slot].count, kSubtreeReferences);
      ASSERT_TRUE(is_due[slot]) << "before its parent, or twice";
      is_due[slot] = false;
      is_due[tree.nodes[slot].left()] = is_due[tree.nodes[slot].right()] = true;
    }
    for (const std::uint32_t slot : cut.subtrees) {
      ASSERT_LE(tree.nodes[slot].count, kSubtreeReferences);
      ASSERT_TRUE(is_due[slot]);
      is_due[slot] = false;
    }
    EXPECT_EQ(std::count(is_due.begin(), is_due.end(), true), 0);
  }
}

TEST(CutTree, ListsSubtreesFromLeftToRight) {
  for (const BinaryTree& tree : sample_trees()) {
    std::vector<std::uint32_t> references;
    for (const std::uint32_t slot : cut_tree(tree).subtrees) {
      const std::vector<std::uint32_t> below = test::references_below(tree, slot);
      references.insert(references.end(), below.begin(), below.end());
    }
    const auto all =
        tree.empty() ? std::vector<std::uint32_t>() : test::references_below(tree, kRoot);
    EXPECT_EQ(references, all);
  }
}

// The size of a subtree is part of what a build gives: it may not follow the machine.
TEST(CutTree, HasSubtreesOfAFixedSize) { EXPECT_EQ(kSubtreeReferences, 4096u); }

TEST(ListInternalNodes, GivesParentsFirstFromACount) {
  const BinaryTree tree = std::move(sample_trees()[2]);
  for (const std::uint32_t min_count : {2u, 7u, 100u, 1000u}) {
    std::vector<std::uint32_t> nodes;
    list_internal_nodes(tree, kRoot, min_count, nodes);
    std::vector<std::size_t> place(tree.nodes.size(), 0);
    for (std::size_t i = 0; i < nodes.size(); ++i) place[nodes[i]] = i + 1;
    std::size_t expected = 0;
    for (const std::uint32_t slot : all_internal_nodes(tree)) {
      if (tree.nodes[slot].count < min_count) continue;
      ++expected;
      ASSERT_GT(place[slot], 0u) << "slot " << slot << " is missing";
      for (const std::uint32_t child : {tree.nodes[slot].left(), tree.nodes[slot].right()}) {
        ASSERT_TRUE(place[child] == 0 || place[child] > place[slot]);
      }
    }
    EXPECT_EQ(nodes.size(), expected);
  }
}

/// Moments at which the slots were visited, from 1; 0 for never.
class Visits {
 public:
  explicit Visits(std::size_t slots) : moments_(slots) {}
  void operator()(std::uint32_t slot) {
    EXPECT_EQ(moments_.at(slot).exchange(++now_), 0) << "slot " << slot << " is visited twice";
  }
  int operator[](std::uint32_t slot) const { return moments_[slot]; }

 private:
  std::vector<std::atomic<int>> moments_;
  std::atomic<int> now_{0};
};

TEST(VisitBottomUp, VisitsLargeNodesOnceAfterTheirChildren) {
  for (const BinaryTree& tree : sample_trees()) {
    for (const unsigned threads : {1, 2, 5}) {
      const test::ThreadCountScope scope(threads);
      for (const std::uint32_t min_count : {2u, 7u, 100u, 5000u}) {
        Visits visits(tree.nodes.size());
        visit_bottom_up(tree, min_count, [&](std::uint32_t slot) { visits(slot); });
        for (const std::uint32_t slot : all_internal_nodes(tree)) {
          const BinaryNode& node = tree.nodes[slot];
          ASSERT_EQ(visits[slot] > 0, node.count >= min_count) << "slot " << slot;
          if (visits[slot] == 0) continue;
          ASSERT_LT(visits[node.left()], visits[slot]);
          ASSERT_LT(visits[node.right()], visits[slot]);
        }
      }
    }
  }
}

TEST(VisitBottomUp, VisitsNoLeaf) {
  for (const BinaryTree& tree : sample_trees()) {
    std::atomic<std::size_t> calls{0};
    visit_bottom_up(tree, 0, [&](std::uint32_t slot) {
      EXPECT_FALSE(tree.nodes[slot].is_leaf());
      ++calls;
    });
    EXPECT_EQ(calls, all_internal_nodes(tree).size());
  }
}

TEST(VisitBottomUp, LetsTheVisitorRearrangeWhatLiesBelow) {
  for (BinaryTree& tree : sample_trees()) {
    if (tree.empty()) continue;
    std::vector<std::uint32_t> mirrored = test::references_below(tree, kRoot);
    std::reverse(mirrored.begin(), mirrored.end());
    std::atomic<std::size_t> calls{0};
    visit_bottom_up(tree, 2, [&](std::uint32_t slot) {
      ++calls;
      std::swap(tree.nodes[tree.nodes[slot].left()], tree.nodes[tree.nodes[slot].right()]);
    });
    EXPECT_EQ(calls, all_internal_nodes(tree).size());
    EXPECT_EQ(test::references_below(tree, kRoot), mirrored);
  }
}

}  // namespace
}  // namespace treelet
