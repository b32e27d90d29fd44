#pragma once

#include <treelet/layout/bvh2.h>
#include <treelet/layout/leaf_collapse.h>
#include <treelet/primitive/reference.h>
#include <treelet/tree/binary_tree.h>
#include <treelet/tree/sah.h>

namespace treelet {

/// Lays nodes and triangles out for traversal.
Bvh2 lay_out_bvh2(const BinaryTree& tree, const References& references, const Mesh& mesh,
                  const LeafCollapse& collapse);

/// Collapses leaves and lays out.
Bvh2 pack_bvh2(const BinaryTree& tree, const References& references, const Mesh& mesh,
               const SahModel& sah);

}  // namespace treelet
