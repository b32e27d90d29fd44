#pragma once

#include <cstdint>

#include <treelet/tree/binary_tree.h>
#include <treelet/tree/sah.h>

namespace treelet {

struct TreeletConfig {
  int size = 7;    ///< leaves of a treelet, 4 to 8
  int rounds = 3;  ///< passes over the tree, 0 to 16
  std::uint32_t gamma =
      0;  ///< references of a treelet root at least, doubled each round; 0: `size`
};

/// Restructures treelets, small subtrees whose leaves may be subtrees again, to their optimal
/// topology, bottom-up, in rounds [KarrasAila2013 s3]. Never raises the SAH cost.
/// Differs: all rounds of a subtree of up to 4096 references, which fits into a core's cache, come
/// before the rounds of the nodes above; in the paper a round covers the whole tree.
void restructure_treelets(BinaryTree& tree, const SahModel& sah, const TreeletConfig& config);

/// The same, one treelet after the other by the readable solver, and the same bytes: what the fast
/// one is tested against. About three times slower.
void restructure_treelets_one_by_one(BinaryTree& tree, const SahModel& sah,
                                     const TreeletConfig& config);

}  // namespace treelet
