#pragma once

#include <bit>
#include <cstdint>
#include <span>

#include <treelet/core/bits.h>
#include <treelet/core/platform.h>
#include <treelet/tree/binary_tree.h>

// What one index of the LBVH does [Karras2012 s3]; host and device loop over it.
//
// Index i owns leaf i and internal node i. In sorted order, node i either begins at i and extends
// to the right or ends at i and extends to the left:
//
//     codes:      00001 00010 00100 00101 10011 11000 11001 11110
//     index:        0     1     2     3     4     5     6     7
//     node 3:     |-----------------------|                        ends at 3, splits after 1
//     node 4:                             |-----------------------|  begins at 4
//
// A node that splits after s has its children in the pair s + 1, so that every index can write its
// two nodes without knowing their parents: of leaf i and node i, the one that ends at i is the
// left child of a parent that splits after i (slot 2 (i + 1)), the one that begins at i is the
// right child of a parent that splits after i - 1 (slot 2 i + 1).

namespace treelet {

/// Sorted Morton codes; equal codes are told apart by their index.
struct RadixTreeView {
  std::span<const std::uint64_t> codes;

  TREELET_HD std::int64_t size() const { return std::int64_t(codes.size()); }

  /// Length of the common prefix of codes i and j, -1 where j is outside.
  TREELET_HD int common_prefix(std::int64_t i, std::int64_t j) const {
    if (j < 0 || j >= size()) return -1;
    const std::uint64_t difference = codes[std::size_t(i)] ^ codes[std::size_t(j)];
    if (difference != 0) return count_leading_zeros(difference);
    return 64 + count_leading_zeros(std::uint64_t(i) ^ std::uint64_t(j));
  }

  /// Whether node i begins at i; else it ends there.
  TREELET_HD bool extends_right(std::int64_t i) const {
    return common_prefix(i, i + 1) > common_prefix(i, i - 1);
  }

  /// The other end of the range of node i.
  TREELET_HD std::int64_t other_end(std::int64_t i, int direction) const {
    const int outside = common_prefix(i, i - direction);
    std::int64_t bound = 2;
    while (common_prefix(i, i + bound * direction) > outside) bound *= 2;
    std::int64_t length = 0;
    for (std::int64_t step = bound / 2; step >= 1; step /= 2) {
      if (common_prefix(i, i + (length + step) * direction) > outside) length += step;
    }
    return i + length * direction;
  }

  /// The last index that shares more with `first` than `last` does: the end of the left child.
  TREELET_HD std::int64_t find_split(std::int64_t first, std::int64_t last) const {
    const int node_prefix = common_prefix(first, last);
    std::int64_t split = first;
    std::int64_t step = last - first;
    do {
      step = (step + 1) / 2;
      const std::int64_t candidate = split + step;
      if (candidate < last && common_prefix(first, candidate) > node_prefix) split = candidate;
    } while (step > 1);
    return split;
  }
};

TREELET_HD constexpr std::uint32_t left_child_slot(std::int64_t split) {
  return std::uint32_t(2 * (split + 1));
}

/// Keys [first, last] of a node that is built from below, and how many bits the keys before and
/// after share with them, -1 where there is none.
struct KeyRange {
  std::int64_t first, last;
  int before, after;

  TREELET_HD bool is_root() const { return before < 0 && after < 0; }
  TREELET_HD std::int64_t count() const { return last - first + 1; }

  /// A node is extended to where its keys share more [Apetrei2014 s3]. One side always shares more:
  /// the bit after the shared ones rises from 0 to 1 at both ends, and if it were the same bit, it
  /// would be 1 in the first key and 0 in the last.
  TREELET_HD bool is_left_child() const { return after > before; }
  /// The last key of the left one of this node and its sibling.
  TREELET_HD std::int64_t parent_split() const { return is_left_child() ? last : first - 1; }

  TREELET_HD std::uint32_t slot() const {
    if (is_root()) return kRoot;
    return is_left_child() ? left_child_slot(last) : std::uint32_t(2 * first + 1);
  }
};

TREELET_HD inline KeyRange leaf_range(const RadixTreeView& tree, std::int64_t i) {
  return {i, i, tree.common_prefix(i, i - 1), tree.common_prefix(i, i + 1)};
}

/// The parent's range, which ends with the sibling's on the side that the child does not know.
TREELET_HD inline KeyRange parent_range(const RadixTreeView& tree, const KeyRange& child,
                                        std::int64_t sibling_end) {
  if (child.is_left_child()) {
    return {child.first, sibling_end, child.before,
            tree.common_prefix(sibling_end, sibling_end + 1)};
  }
  return {sibling_end, child.last, tree.common_prefix(sibling_end, sibling_end - 1), child.after};
}

/// Writes leaf i and, but for the last index, internal node i. Boxes are left to refit.
TREELET_HD inline void emit_nodes(const RadixTreeView& tree, std::int64_t i,
                                  std::uint32_t reference, BinaryNode* nodes) {
  const bool right = tree.extends_right(i);
  const std::uint32_t begins_here = std::uint32_t(2 * i + 1), ends_here = left_child_slot(i);
  const bool is_last = i + 1 == tree.size();

  const std::uint32_t leaf_slot = tree.size() == 1 ? kRoot : right ? ends_here : begins_here;
  nodes[leaf_slot].index = reference;
  nodes[leaf_slot].count = 1;
  if (is_last) return;

  const std::int64_t end = tree.other_end(i, right ? 1 : -1);
  const std::int64_t first = right ? i : end, last = right ? end : i;
  const std::uint32_t node_slot = i == 0 ? kRoot : right ? begins_here : ends_here;
  nodes[node_slot].index = left_child_slot(tree.find_split(first, last));
  nodes[node_slot].count = std::uint32_t(last - first + 1);
}

}  // namespace treelet
