#pragma once

#include <cstdint>

#include <treelet/tree/binary_tree.h>
#include <treelet/tree/sah.h>

namespace treelet {

struct RotationConfig {
  int rounds = 8;          ///< passes that take the best rotation of each node, at most
  int anneal = 0;          ///< passes before those that also take rotations that cost something
  std::uint32_t seed = 1;  ///< of annealing
};

/// Swaps a child of a node with a grandchild on the other side, or two grandchildren, wherever that
/// lowers the cost, bottom-up, until no swap does or the rounds are over [Kensler2008]. Never
/// raises the SAH cost, leaves of the layout counted. Throws std::invalid_argument for negative
/// rounds or passes.
void rotate_nodes(BinaryTree& tree, const SahModel& sah, const RotationConfig& config = {});

}  // namespace treelet
