#pragma once

#include <treelet/layout/bvh8.h>
#include <treelet/layout/wide_collapse.h>
#include <treelet/primitive/reference.h>
#include <treelet/tree/binary_tree.h>

namespace treelet {

/// Collapses to eight children a node and lays nodes and triangles out for traversal.
Bvh8 pack_bvh8(const BinaryTree& tree, const References& references, const Mesh& mesh,
               const WideCostModel& model);

}  // namespace treelet
