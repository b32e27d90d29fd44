#pragma once

#include <treelet/tree/binary_tree.h>
#include <treelet/tree/sah.h>

namespace treelet {

struct AgglomerationConfig {
  int size = 9;    ///< leaves of a treelet, 3 to 32
  int rounds = 2;  ///< passes over the tree
};
constexpr int kMinAgglomeratedSize = 3, kMaxAgglomeratedSize = 32;

/// Rebuilds treelets from their leaves by merging, again and again, the two whose common box is
/// smallest [DominguesPedrini2015]: not the best topology, as restructure_treelets finds, but of
/// treelets far larger than can be tried. A treelet is replaced only where that lowers the SAH
/// cost, leaves of the layout counted. Throws std::invalid_argument for sizes out of range and
/// negative rounds.
void agglomerate_treelets(BinaryTree& tree, const SahModel& sah,
                          const AgglomerationConfig& config = {});

}  // namespace treelet
