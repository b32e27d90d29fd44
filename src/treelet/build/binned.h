#pragma once

#include <treelet/primitive/reference.h>
#include <treelet/tree/binary_tree.h>

namespace treelet {

struct BinnedConfig {
  int bins = 32;  ///< of an axis, 2 to 128
};

/// Top-down SAH judged at the planes between equal bins of the centroids, along all three axes
/// [Wald2007]. Nearly the tree of the full sweep in less time: nothing is sorted but where few
/// references are left.
/// Throws std::invalid_argument for bins out of range.
BinaryTree build_binned(const References& references, const BinnedConfig& config = {});

/// Throws std::invalid_argument where there cannot be so many bins.
void require_valid_bins(int bins);

}  // namespace treelet
