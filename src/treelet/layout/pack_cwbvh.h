#pragma once

#include <cstdint>

#include <treelet/layout/cwbvh.h>
#include <treelet/layout/wide_collapse.h>
#include <treelet/primitive/reference.h>
#include <treelet/tree/binary_tree.h>

namespace treelet {

/// What the collapse takes a compressed node and its triangles to cost, in visits of a node.
struct CwbvhCostModel {
  float node_cost = 1.0f;
  /// By count of what a device does: three loads of 16 bytes to a node's five, one exact test of
  /// three edges to eight boxes that have to be decoded.
  float triangle_cost = 0.4f;
  std::uint32_t leaf_limit = CwbvhNode::kMaxLeaf;  ///< triangles in a leaf at most

  /// Throws std::invalid_argument for leaves of more or fewer triangles than 1 to 3.
  WideCostModel checked() const;
};

/// Puts the children of collapsed nodes into slots and compresses their boxes
/// [YlitieKarrasLaine2017 s3].
Cwbvh lay_out_cwbvh(const BinaryTree& tree, const References& references, const Mesh& mesh,
                    const WideCollapse& collapse);

/// Collapses to eight children a node and lays out.
Cwbvh pack_cwbvh(const BinaryTree& tree, const References& references, const Mesh& mesh,
                 const CwbvhCostModel& model);

}  // namespace treelet
