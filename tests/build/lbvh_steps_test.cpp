#include <treelet/build/lbvh_steps.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "support/random.h"

namespace treelet {
namespace {

using test::Random;
using Codes = std::vector<std::uint64_t>;

struct NodeRange {
  std::int64_t first, last, split;
};

NodeRange range_of_node(const RadixTreeView& tree, std::int64_t i) {
  const bool right = tree.extends_right(i);
  const std::int64_t end = tree.other_end(i, right ? 1 : -1);
  const std::int64_t first = std::min(i, end), last = std::max(i, end);
  return {first, last, tree.find_split(first, last)};
}

// [Karras2012 fig. 3]
const Codes kWorkedExample{0b00001, 0b00010, 0b00100, 0b00101, 0b10011, 0b11000, 0b11001, 0b11110};

TEST(RadixTree, OfTheWorkedExampleHasItsRangesAndSplits) {
  const RadixTreeView tree{kWorkedExample};
  const NodeRange expected[] = {{0, 7, 3}, {0, 1, 0}, {2, 3, 2}, {0, 3, 1},
                                {4, 7, 4}, {5, 7, 6}, {5, 6, 5}};
  for (std::int64_t i = 0; i < 7; ++i) {
    const NodeRange range = range_of_node(tree, i);
    EXPECT_EQ(range.first, expected[i].first) << "node " << i;
    EXPECT_EQ(range.last, expected[i].last) << "node " << i;
    EXPECT_EQ(range.split, expected[i].split) << "node " << i;
  }
}

TEST(RadixTree, OfTheWorkedExampleHasItsNodes) {
  struct Expected {
    std::uint32_t slot, index, count;
  };
  // An internal node that splits after s has its children at 2 (s + 1); leaf i holds 100 + i.
  const Expected expected[] = {{0, 8, 8},   {4, 2, 2},    {5, 6, 2},    {8, 4, 4},    {9, 10, 4},
                               {11, 14, 3}, {14, 12, 2},  {2, 100, 1},  {3, 101, 1},  {6, 102, 1},
                               {7, 103, 1}, {10, 104, 1}, {12, 105, 1}, {13, 106, 1}, {15, 107, 1}};
  BinaryTree built(8);
  for (std::int64_t i = 0; i < 8; ++i) {
    emit_nodes({kWorkedExample}, i, std::uint32_t(100 + i), built.nodes.data());
  }
  for (const Expected& node : expected) {
    EXPECT_EQ(built.nodes[node.slot].index, node.index) << "slot " << node.slot;
    EXPECT_EQ(built.nodes[node.slot].count, node.count) << "slot " << node.slot;
  }
}

TEST(RadixTree, OfOneCodeIsALeaf) {
  const Codes codes{42};
  BinaryTree built(1);
  emit_nodes({codes}, 0, 7, built.nodes.data());
  EXPECT_EQ(built.nodes[kRoot].index, 7u);
  EXPECT_EQ(built.nodes[kRoot].count, 1u);
}

/// The code and then the index, as a string of 128 bits.
std::string key_bits(const Codes& codes, std::int64_t i) {
  std::string bits;
  for (int bit = 63; bit >= 0; --bit) bits += codes[std::size_t(i)] >> bit & 1 ? '1' : '0';
  for (int bit = 63; bit >= 0; --bit) bits += std::uint64_t(i) >> bit & 1 ? '1' : '0';
  return bits;
}

int naive_prefix(const Codes& codes, std::int64_t i, std::int64_t j) {
  if (j < 0 || j >= std::int64_t(codes.size())) return -1;
  const std::string a = key_bits(codes, i), b = key_bits(codes, j);
  return int(std::mismatch(a.begin(), a.end(), b.begin()).first - a.begin());
}

Codes random_codes(std::size_t size, int bits, Random& random) {
  Codes codes(size);
  for (std::uint64_t& code : codes) code = random.bits() >> (64 - bits);
  std::sort(codes.begin(), codes.end());
  return codes;
}

/// Checks node `node` of the range, found from the top down by looking at every code, and all
/// below.
void expect_ranges_below(const RadixTreeView& tree, const Codes& codes, std::int64_t first,
                         std::int64_t last, std::int64_t node) {
  if (first == last) return;
  const int prefix = naive_prefix(codes, first, last);
  std::int64_t split = first;
  while (naive_prefix(codes, first, split + 1) > prefix) ++split;
  const NodeRange range = range_of_node(tree, node);
  ASSERT_EQ(range.first, first);
  ASSERT_EQ(range.last, last);
  ASSERT_EQ(range.split, split);
  expect_ranges_below(tree, codes, first, split, split);
  expect_ranges_below(tree, codes, split + 1, last, split + 1);
}

TEST(RadixTreeView, AgreesWithSplittingFromTheTop) {
  constexpr std::uint64_t seed = 101;
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  for (const int bits : {1, 3, 6, 20, 63}) {  // from many duplicates to none
    for (const std::size_t size : {2, 3, 7, 8, 9, 64, 100}) {
      SCOPED_TRACE(std::to_string(size) + " codes of " + std::to_string(bits) + " bits");
      const Codes codes = random_codes(size, bits, random);
      expect_ranges_below({codes}, codes, 0, std::int64_t(size) - 1, 0);
      if (HasFailure()) return;
    }
  }
}

TEST(RadixTreeView, CommonPrefixCountsBits) {
  constexpr std::uint64_t seed = 102;
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  for (const int bits : {2, 63, 64}) {
    const Codes codes = random_codes(24, bits, random);
    const RadixTreeView tree{codes};
    for (std::int64_t i = 0; i < 24; ++i) {
      for (std::int64_t j = -2; j < 26; ++j) {
        if (j == i) continue;
        ASSERT_EQ(tree.common_prefix(i, j), naive_prefix(codes, i, j));
      }
    }
  }
}

/// Builds from below, one leaf after the other in this order; what a child knows waits at its
/// parent's split.
BinaryTree climb_from_leaves(const Codes& codes, const std::vector<std::size_t>& order) {
  const RadixTreeView tree{codes};
  BinaryTree built(codes.size());
  std::vector<std::int64_t> far_ends(codes.size(), -1);
  for (const std::size_t leaf : order) {
    KeyRange range = leaf_range(tree, std::int64_t(leaf));
    built.nodes[range.slot()] = {{}, std::uint32_t(leaf), {}, 1};
    while (!range.is_root()) {
      std::int64_t& far_end = far_ends[std::size_t(range.parent_split())];
      const std::int64_t mine = range.is_left_child() ? range.first : range.last;
      const std::int64_t sibling_end = std::exchange(far_end, mine);
      if (sibling_end < 0) break;
      const std::uint32_t children = left_child_slot(range.parent_split());
      range = parent_range(tree, range, sibling_end);
      built.nodes[range.slot()] = {{}, children, {}, std::uint32_t(range.last - range.first + 1)};
    }
  }
  return built;
}

TEST(KeyRange, ClimbsToTheNodesThatAreEmitted) {
  constexpr std::uint64_t seed = 103;
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  for (const int bits : {1, 3, 6, 20, 63}) {
    for (const std::size_t size : {1, 2, 3, 7, 8, 9, 64, 1000}) {
      const Codes codes = random_codes(size, bits, random);
      BinaryTree expected(size);
      std::vector<std::size_t> order(size);
      for (std::size_t i = 0; i < size; ++i) {
        emit_nodes({codes}, std::int64_t(i), std::uint32_t(i), expected.nodes.data());
        order[i] = i;
        std::swap(order[i], order[random.below(i + 1)]);
      }
      const BinaryTree built = climb_from_leaves(codes, order);
      for (std::size_t slot = 0; slot < 2 * size; ++slot) {
        ASSERT_EQ(built.nodes[slot].index, expected.nodes[slot].index) << "slot " << slot;
        ASSERT_EQ(built.nodes[slot].count, expected.nodes[slot].count) << "slot " << slot;
      }
    }
  }
}

}  // namespace
}  // namespace treelet
