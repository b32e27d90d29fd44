#pragma once

#include <cstdint>

#include <treelet/core/array.h>
#include <treelet/primitive/reference.h>
#include <treelet/tree/binary_tree.h>

namespace treelet {

/// How many different faces each subtree holds: what it would take as a leaf, where the pieces of a
/// split face are one triangle again.
class FaceCounts {
 public:
  FaceCounts(const BinaryTree& tree, const References& references);

  std::uint32_t operator[](std::size_t slot) const {
    return counts_.empty() ? nodes_[slot].count : counts_[slot];
  }

 private:
  const Array<BinaryNode>& nodes_;
  Array<std::uint32_t> counts_;  // by slot; empty where no face is repeated
};

}  // namespace treelet
