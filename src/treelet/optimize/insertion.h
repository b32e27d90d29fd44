#pragma once

#include <cstdint>

#include <treelet/tree/binary_tree.h>
#include <treelet/tree/sah.h>

namespace treelet {

struct InsertionConfig {
  float percent = 1.0f;    ///< of the internal nodes, in a batch
  int batches = 40;        ///< at most
  std::uint32_t seed = 1;  ///< of batches that are picked at random
};

/// Takes the most wasteful nodes apart, in batches, and inserts the two children of each again
/// where they enlarge the boxes above them least [BittnerHapalaHavran2013]. Unlike
/// restructure_treelets it sees the whole tree; it is slow, as each insertion changes the tree that
/// the next one searches. Ends early where batches have stopped to help, and keeps the best tree:
/// never raises the SAH cost, leaves of the layout counted.
/// Throws std::invalid_argument for percents outside of 0 to 100 and negative batches.
void insert_nodes(BinaryTree& tree, const SahModel& sah, const InsertionConfig& config = {});

}  // namespace treelet
