#pragma once

#include <treelet/tree/binary_tree.h>

namespace treelet {

struct ReinsertionConfig {
  float percent = 2.0f;  ///< of all nodes, those of largest area, are looked at in a round
  int rounds = 2;
};

/// Takes large nodes out of the tree and puts each back where it enlarges the boxes above it least
/// [MeisterBittner2018]: unlike treelets, it carries a subtree as far as it has to go. The sum of
/// the areas of internal nodes never grows. Throws std::invalid_argument for percents outside of 0
/// to 100 and negative rounds.
void reinsert_nodes(BinaryTree& tree, const ReinsertionConfig& config);

}  // namespace treelet
