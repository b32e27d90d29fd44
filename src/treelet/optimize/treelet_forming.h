#pragma once

#include <array>
#include <cstdint>

#include <treelet/optimize/pair_costs.h>
#include <treelet/optimize/treelet_solver.h>
#include <treelet/tree/binary_tree.h>

namespace treelet {

/// A treelet where it lies: its leaves' slots and the pairs of its internal nodes' children.
///
///              root              leaves  a b c d        pairs  (x y) (a b) (c d) as they were
///              opened
///             /    \             n leaves, n - 1 internal nodes, n - 1 pairs
///            x      y
///           / \    / \           Rewiring copies leaves to other slots of the same pairs; what
///           lies
///          a   b  c   d          below them stays where it is.
struct Treelet {
  int size = 0;
  std::array<std::uint32_t, kMaxTreeletSize> leaf_slots;
  std::array<std::uint32_t, kMaxTreeletSize - 1> pairs;
};

/// Grows a treelet from its root, an internal node, by opening the leaf of largest area until there
/// are `size` leaves or all that are left are leaves of the tree [KarrasAila2013 s3.1].
Treelet form_treelet(const BinaryTree& tree, std::uint32_t root, int size);

TreeletLeaves gather_leaves(const BinaryTree& tree, const PairCosts& costs, const Treelet& treelet);

}  // namespace treelet
