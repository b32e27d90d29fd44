#include <treelet/tree/subtree_levels.cuh>

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "cuda/schedules.h"
#include "cuda/uploaded_tree.h"
#include "support/meshes.h"
#include "support/trees.h"

namespace treelet::cuda {
namespace {

using test::kStream;

constexpr unsigned kThreads = 128;

/// What a block finds out about a subtree, in device memory.
struct Report {
  std::uint32_t* slots;    // in order
  std::uint32_t* ends;     // of levels
  int* sizes;              // depth, count
  std::uint32_t* heights;  // by slot: listed nodes on the longest way down
  std::uint32_t* depths;   // by slot: nodes above
  std::uint32_t* lanes;    // by slot: those that visited it
};

__device__ void copy_levels(const SubtreeLevels& levels, const Report& report) {
  for (int i = int(threadIdx.x); i < levels.count; i += int(blockDim.x)) {
    report.slots[i] = levels.slots[i];
  }
  for (int level = int(threadIdx.x); level < levels.depth; level += int(blockDim.x)) {
    report.ends[level] = levels.end(level);
  }
  if (threadIdx.x > 0) return;
  report.sizes[0] = levels.depth;
  report.sizes[1] = levels.count;
}

__device__ void visit_all(const BinaryNode* nodes, std::uint32_t min_count,
                          const SubtreeLevels& levels, const Report& report) {
  const auto height = [&](std::uint32_t slot) {
    const BinaryNode& node = nodes[slot];
    return node.is_leaf() || node.count < min_count ? 0 : report.heights[slot];
  };
  visit_bottom_up(levels, [&](std::uint32_t slot) {
    report.heights[slot] = 1 + std::max(height(nodes[slot].left()), height(nodes[slot].right()));
  });
  visit_top_down(levels, [&](std::uint32_t slot) {
    report.depths[nodes[slot].left()] = report.depths[slot] + 1;
    report.depths[nodes[slot].right()] = report.depths[slot] + 1;
  });
  visit_bottom_up_by_warps(levels, [&](std::uint32_t slot) {
    atomicAdd(&report.lanes[slot], 1u << (lane_index() / 8));
  });
}

/// Twice, so that one list follows upon another.
__global__ void report_levels(const BinaryNode* nodes, std::uint32_t min_count, Report report) {
  __shared__ SubtreeLevels levels;
  const auto keep = [=](const BinaryNode& node) { return node.count >= min_count; };
  list_levels(nodes, kRoot, KeepAll{}, levels);
  list_levels(nodes, kRoot, keep, levels);
  copy_levels(levels, report);
  visit_all(nodes, min_count, levels, report);
}

class Reporter {
 public:
  Reporter(const BinaryTree& tree, std::uint32_t min_count)
      : size_(std::max<std::size_t>(tree.nodes.size(), 2)),
        words_(5 * size_ + 2, kStream),
        uploaded_(tree) {
    fill_device_bytes(words_.data(), 0, words_.bytes(), kStream);
    std::uint32_t* word = words_.data();
    const auto take = [&] { return std::exchange(word, word + size_); };
    const Report report{take(), take(), sizes_.data(), take(), take(), take()};
    launch(kStream, {1, kThreads}, report_levels, uploaded_.tree().nodes, min_count, report);
    all_ = download(words_);
    const Array<int> sizes = download(sizes_);
    depth = std::size_t(sizes[0]);
    count = std::size_t(sizes[1]);
  }

  std::uint32_t slot(std::size_t i) const { return all_[i]; }
  std::uint32_t end(std::size_t level) const { return all_[size_ + level]; }
  std::uint32_t height(std::uint32_t slot) const { return all_[2 * size_ + slot]; }
  std::uint32_t depth_of(std::uint32_t slot) const { return all_[3 * size_ + slot]; }
  std::uint32_t lanes(std::uint32_t slot) const { return all_[4 * size_ + slot]; }

  std::size_t depth = 0, count = 0;

 private:
  std::size_t size_;
  DeviceArray<std::uint32_t> words_;
  DeviceArray<int> sizes_{2, kStream};
  test::UploadedTree uploaded_;
  Array<std::uint32_t> all_;
};

/// Levels of internal nodes of at least min_count references, each from left to right.
std::vector<std::vector<std::uint32_t>> levels_on_host(const BinaryTree& tree,
                                                       std::uint32_t min_count) {
  const auto is_listed = [&](std::uint32_t slot) {
    return !tree.nodes[slot].is_leaf() && tree.nodes[slot].count >= min_count;
  };
  std::vector<std::vector<std::uint32_t>> levels;
  std::vector<std::uint32_t> level;
  if (is_listed(kRoot)) level.push_back(kRoot);
  while (!level.empty()) {
    levels.push_back(level);
    level.clear();
    for (const std::uint32_t slot : levels.back()) {
      const BinaryNode& node = tree.nodes[slot];
      if (is_listed(node.left())) level.push_back(node.left());
      if (is_listed(node.right())) level.push_back(node.right());
    }
  }
  return levels;
}

/// Levels below each listed node, itself included, by slot.
std::vector<std::uint32_t> heights_on_host(const BinaryTree& tree,
                                           const std::vector<std::vector<std::uint32_t>>& levels) {
  std::vector<std::uint32_t> heights(tree.nodes.size(), 0);
  for (auto level = levels.rbegin(); level != levels.rend(); ++level) {
    for (const std::uint32_t slot : *level) {
      const BinaryNode& node = tree.nodes[slot];
      heights[slot] = 1 + std::max(heights[node.left()], heights[node.right()]);
    }
  }
  return heights;
}

void expect_levels(const BinaryTree& tree, std::uint32_t min_count) {
  SCOPED_TRACE(std::to_string(tree.reference_count()) + " references, at least " +
               std::to_string(min_count));
  const auto levels = levels_on_host(tree, min_count);
  const std::vector<std::uint32_t> heights = heights_on_host(tree, levels);
  const Reporter report(tree, min_count);
  ASSERT_EQ(report.depth, levels.size());
  std::size_t place = 0;
  for (std::size_t depth = 0; depth < levels.size(); ++depth) {
    for (const std::uint32_t slot : levels[depth]) {
      ASSERT_EQ(report.slot(place++), slot);
      ASSERT_EQ(report.depth_of(slot), depth);
      ASSERT_EQ(report.height(slot), heights[slot]);
      ASSERT_EQ(report.lanes(slot), 8u * 15) << "all lanes once";
    }
    ASSERT_EQ(report.end(depth), place);
  }
  ASSERT_EQ(report.count, place);
}

References soup(std::size_t count) {
  return create_references(test::triangle_soup(count, 321).view());
}

TEST(SubtreeLevels, AreBreadthFirst) {
  test::for_each_schedule([&](std::uint64_t seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    for (const std::size_t count : {5, 200, 4096}) {
      const BinaryTree tree = test::random_tree(soup(count), 322 + seed);
      for (const std::uint32_t min_count : {0u, 2u, 7u, 50u, 4096u}) expect_levels(tree, min_count);
    }
  });
}

TEST(SubtreeLevels, SlowTakeTheDeepestAndTheWidestSubtree) {
  expect_levels(test::chain_tree(soup(kSubtreeReferences)), kAllInternal);
  expect_levels(test::balanced_tree(soup(kSubtreeReferences)), kAllInternal);
}

TEST(SubtreeLevels, OfLeavesAndSmallTreesAreShort) {
  for (const std::size_t count : {1, 2, 3, 4, 31, 32, 33, 127, 128, 129}) {
    expect_levels(test::balanced_tree(soup(count)), 0);
    expect_levels(test::balanced_tree(soup(count)), 3);
    expect_levels(test::chain_tree(soup(count)), 3);
  }
}

}  // namespace
}  // namespace treelet::cuda
