#include <treelet/tree/device_cut.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "cuda/schedules.h"
#include "cuda/uploaded_tree.h"
#include "support/meshes.h"
#include "support/trees.h"

namespace treelet::cuda {
namespace {

using test::kStream;

struct Cut {
  std::vector<std::uint32_t> subtrees, top, top_ends;

  friend bool operator==(const Cut&, const Cut&) = default;
};

/// Level after level, each from left to right.
Cut cut_on_host(const BinaryTree& tree) {
  Cut cut{{}, {}, {0}};
  std::vector<std::uint32_t> level, next;
  if (!tree.empty()) level.push_back(kRoot);
  for (; !level.empty(); level = std::exchange(next, {})) {
    for (const std::uint32_t slot : level) {
      const BinaryNode& node = tree.nodes[slot];
      (node.count > kSubtreeReferences ? cut.top : cut.subtrees).push_back(slot);
      if (node.count > kSubtreeReferences) next.insert(next.end(), {node.left(), node.right()});
    }
    if (cut.top_ends.back() < cut.top.size()) {
      cut.top_ends.push_back(std::uint32_t(cut.top.size()));
    }
  }
  return cut;
}

Cut cut_on_device(const BinaryTree& tree, std::uint32_t spare = 0) {
  test::UploadedTree uploaded(tree, spare);
  DeviceArray<std::byte> block;
  const DeviceCut cut = test::carve(
      block, [&](Carver& carver) { return carve_cut(carver, uploaded.tree().capacity); });
  cut_tree(uploaded.tree(), cut, kStream);
  const DeviceCutCounts counts = download(cut.counts, 1, kStream)[0];
  const auto list = [](const std::uint32_t* values, std::size_t size) {
    const Array<std::uint32_t> array = download(values, size, kStream);
    return std::vector<std::uint32_t>(array.begin(), array.end());
  };
  return {list(cut.subtrees, counts.subtrees), list(cut.top, counts.top),
          list(cut.top_ends, counts.top_depth + 1)};
}

References soup(std::size_t count) {
  return create_references(test::triangle_soup(count, 301).view());
}

std::vector<std::uint32_t> sorted(std::vector<std::uint32_t> values) {
  std::sort(values.begin(), values.end());
  return values;
}

TEST(DeviceCut, IsBreadthFirst) {
  const References references = soup(60'000);
  test::for_each_schedule([&](std::uint64_t seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const BinaryTree random = test::random_tree(references, 302 + seed);
    EXPECT_EQ(cut_on_device(random), cut_on_host(random));
    const BinaryTree balanced = test::balanced_tree(references);
    EXPECT_EQ(cut_on_device(balanced), cut_on_host(balanced));
  });
}

TEST(DeviceCut, HasTheNodesOfTheHostsCut) {
  const BinaryTree tree = test::random_tree(soup(60'000), 306);
  const Cut cut = cut_on_device(tree);
  const TreeCut expected = treelet::cut_tree(tree);
  EXPECT_GT(expected.top.size(), 10u);
  EXPECT_EQ(sorted(cut.top), sorted(expected.top));
  EXPECT_EQ(sorted(cut.subtrees), sorted(expected.subtrees));
}

TEST(DeviceCut, OfAChainFillsAllThatIsCarved) {
  const std::uint32_t count = kSubtreeReferences + 100;
  const BinaryTree tree = test::chain_tree(soup(count));
  const Cut cut = cut_on_device(tree);
  EXPECT_EQ(cut, cut_on_host(tree));
  EXPECT_EQ(cut.top.size(), max_top_nodes(count));
  EXPECT_EQ(cut.subtrees.size(), max_top_nodes(count) + 1);
  EXPECT_EQ(cut.top_ends.size(), max_top_nodes(count) + 1);
}

TEST(DeviceCut, OfSizesAroundASubtree) {
  for (const std::uint32_t count : {0u, 1u, 2u, 3u, 4095u, 4096u, 4097u, 8192u, 8193u}) {
    SCOPED_TRACE(std::to_string(count) + " references");
    const BinaryTree tree = test::balanced_tree(soup(count));
    EXPECT_EQ(cut_on_device(tree), cut_on_host(tree));
    EXPECT_EQ(cut_on_device(tree, 5000), cut_on_host(tree));
  }
}

TEST(DeviceCut, NoTreeHasMoreTopNodesThanItsBound) {
  EXPECT_EQ(max_top_nodes(0), 0u);
  EXPECT_EQ(max_top_nodes(kSubtreeReferences), 0u);
  EXPECT_EQ(max_top_nodes(kSubtreeReferences + 1), 1u);
  for (std::uint64_t seed = 310; seed < 320; ++seed) {
    const std::size_t count = kSubtreeReferences + 100 * (seed - 309);
    const BinaryTree tree = test::random_tree(soup(count), seed);
    EXPECT_LE(treelet::cut_tree(tree).top.size(), max_top_nodes(std::uint32_t(count)));
  }
}

}  // namespace
}  // namespace treelet::cuda
