#pragma once

#include <treelet/tree/binary_tree.h>
#include <treelet/tree/sah.h>

namespace treelet {

struct ReinsertionConfig {
  float percent = 2.0f;  ///< of all nodes, those of largest area, are looked at in a round
  int rounds = 2;
};

/// Takes large nodes out of the tree and puts each back where it enlarges the boxes above it least
/// [MeisterBittner2018]: unlike treelets, it carries a subtree as far as it has to go. Moves are
/// judged by the areas of internal nodes, and rounds by the SAH cost, leaves of the layout counted:
/// the tree of the cheapest round is kept, so that the cost never rises. Throws
/// std::invalid_argument for percents outside of 0 to 100 and negative rounds.
void reinsert_nodes(BinaryTree& tree, const SahModel& sah, const ReinsertionConfig& config);

}  // namespace treelet
