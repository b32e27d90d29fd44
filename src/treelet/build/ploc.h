#pragma once

#include <treelet/primitive/reference.h>
#include <treelet/tree/binary_tree.h>

namespace treelet {

struct PlocConfig {
  int radius = 25;  ///< clusters on either side among which the nearest is looked for, 1 to 100
};
constexpr int kMinPlocRadius = 1, kMaxPlocRadius = 100;

/// Parallel locally-ordered clustering [MeisterBittner2018]: all clusters along the Morton curve
/// look for the neighbour with which their merged box is smallest, and those that are each other's
/// nearest become siblings, in rounds until one is left.
/// Differs from build_hploc: clusters see their neighbours across the whole scene in every round,
/// not only those below the same node of the radix tree.
/// Throws std::invalid_argument for a radius out of range.
BinaryTree build_ploc(const References& references, const PlocConfig& config = {});

}  // namespace treelet
