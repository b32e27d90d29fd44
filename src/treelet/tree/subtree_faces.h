#pragma once

#include <cstdint>

#include <treelet/tree/binary_tree.h>

namespace treelet::cuda {

/// How many different faces each subtree of a tree over split references holds, in device memory.
/// By pair: entry p is about the node whose children are slots 2p and 2p + 1. Both are null where
/// references are whole triangles: as many as references.
struct SubtreeFaces {
  std::uint32_t* counts = nullptr;
  std::uint32_t* above = nullptr;  ///< slot of that node

  TREELET_HD std::uint32_t count(const BinaryNode& node) const {
    return counts == nullptr || node.is_leaf() ? node.count : counts[node.left() / 2];
  }
};

}  // namespace treelet::cuda
