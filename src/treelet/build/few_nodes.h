#pragma once

#include <cstdint>
#include <span>

#include <treelet/build/node_bins.h>

namespace treelet {

/// So few nodes cost less to sort than to put into bins.
constexpr std::size_t kFewNodes = 16;

/// The best of all splits between centroids, of two to kFewNodes nodes.
struct FewNodesSplit {
  NodeSplit split;
  std::uint32_t goes_right = 0;  ///< a bit a node
};
FewNodesSplit split_few_nodes(std::span<const BinaryNode> nodes);

}  // namespace treelet
