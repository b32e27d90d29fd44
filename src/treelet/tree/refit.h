#pragma once

#include <treelet/primitive/device_references.h>
#include <treelet/primitive/reference.h>
#include <treelet/tree/binary_tree.h>
#include <treelet/tree/device_cut.h>
#include <treelet/tree/device_tree.h>
#include <treelet/tree/sah.h>
#include <treelet/tree/subtree_faces.h>

namespace treelet {

/// Makes each box the union of its references' boxes. Needs the topology and the counts.
void refit(BinaryTree& tree, const References& references);

/// SAH cost of each subtree by slot, in triangle tests times half area, with the leaves that are
/// cheaper as one leaf counted as such.
Array<float> compute_costs(const BinaryTree& tree, const SahModel& sah);

/// Cost of a random ray through the whole tree: compute_costs at the root over the root's half
/// area, and 0 where that area is 0.
double sah_cost(const BinaryTree& tree, const SahModel& sah);

namespace cuda {

// The same in device memory, to the bit. The cut is that of the tree.

void refit(const DeviceTree& tree, const DeviceCut& cut, const DeviceReferences& references,
           Stream stream);

/// Writes a cost for each slot of the tree; with counts of faces, of leaves in which the pieces of
/// a face count as one triangle, as in collapsed_sah_cost (layout/leaf_collapse.h).
void compute_costs(const DeviceTree& tree, const DeviceCut& cut, const SubtreeFaces& faces,
                   const SahModel& sah, float* costs, Stream stream);

/// Writes sah_cost from the costs by slot.
void normalize_cost(const DeviceTree& tree, const float* costs, double* cost, Stream stream);

}  // namespace cuda

}  // namespace treelet
