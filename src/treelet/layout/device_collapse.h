#pragma once

#include <cstdint>

#include <treelet/core/carver.h>
#include <treelet/core/stream.h>
#include <treelet/layout/device_layout.h>
#include <treelet/layout/wide_collapse.h>
#include <treelet/tree/device_cut.h>
#include <treelet/tree/device_tree.h>
#include <treelet/tree/sah.h>
#include <treelet/tree/subtree_faces.h>

// What is decided about each internal node before packing, and where its part of the layout goes.
// Entries go by pair: entry p is about the node whose children are slots 2p and 2p + 1. A leaf of
// the binary tree needs none, for what there is to know about it is cheap to find again. What is
// known first makes room for what is known later.

namespace treelet::cuda {

/// Leaf sizes that the device packs into a Bvh2; an unsplit leaf is walked with a stack of as
/// many slots.
constexpr std::uint32_t kMaxBvh2Leaf = 64;

/// What becomes of an internal node in a Bvh2.
struct LeafEntry {
  static constexpr std::uint32_t kNowhere = 0xffffffff;

  union {
    float cost;                ///< until the parent has been decided
    std::uint32_t first_node;  ///< then: where it goes in the layout
  };
  std::uint32_t nodes : 31;  ///< of the layout in the subtree
  std::uint32_t is_leaf : 1;
  std::uint32_t height;          ///< nodes on the longest way down; 0 for a leaf
  std::uint32_t first_triangle;  ///< kNowhere for what is a leaf or inside of one
};
static_assert(sizeof(LeafEntry) == 16);

/// What becomes of an internal node in a Bvh8 or a Cwbvh.
struct WideEntry {
  /// What a subtree whose root is a node of the layout takes, and where.
  struct Place {
    std::uint32_t nodes, blocks, triangles, height;
    std::uint32_t first_node, first_block;
    std::uint32_t first_below;  ///< of a cwbvh, where the nodes below the first are
  };

  WideDecision decision;
  union {
    float costs[WideChoice::kWidth - 1];  ///< until all choices are made
    Place place;                          ///< then: of nodes of the layout
  };
};
static_assert(sizeof(WideEntry) == 32);

/// Makes the decisions of collapse_leaves (layout/leaf_collapse.h), places nodes and triangles, and
/// writes the totals to *size. For leaf limits of up to kMaxBvh2Leaf. `entries` has as many values
/// as the tree has capacity. Where there are counts of faces, those of nodes that remain become
/// counts of the triangles in the leaves below.
void collapse_leaves(const DeviceTree& tree, const DeviceCut& cut, const SubtreeFaces& faces,
                     const SahModel& sah, LeafEntry* entries, LayoutSize* size, Stream stream);

/// Makes the decisions of collapse_wide (layout/wide_collapse.h).
void choose_wide(const DeviceTree& tree, const DeviceCut& cut, const SubtreeFaces& faces,
                 const WideCostModel& model, WideEntry* entries, Stream stream);

/// Places the nodes and blocks that have been chosen as the layout wants them and writes the totals
/// to *size.
void place_bvh8(const DeviceTree& tree, const DeviceCut& cut, const SubtreeFaces& faces,
                WideEntry* entries, LayoutSize* size, Stream stream);
void place_cwbvh(const DeviceTree& tree, const DeviceCut& cut, const SubtreeFaces& faces,
                 WideEntry* entries, LayoutSize* size, Stream stream);

}  // namespace treelet::cuda
