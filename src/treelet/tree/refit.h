#pragma once

#include <treelet/primitive/reference.h>
#include <treelet/tree/binary_tree.h>
#include <treelet/tree/sah.h>

namespace treelet {

/// Makes each box the union of its references' boxes. Needs the topology and the counts.
void refit(BinaryTree& tree, const References& references);

/// SAH cost of each subtree by slot, in triangle tests times half area, with the leaves that are
/// cheaper as one leaf counted as such.
Array<float> compute_costs(const BinaryTree& tree, const SahModel& sah);

/// Cost of a random ray through the whole tree: compute_costs at the root over the root's half
/// area, and 0 where that area is 0.
double sah_cost(const BinaryTree& tree, const SahModel& sah);

}  // namespace treelet
