#pragma once

#include <cstdint>

#include <treelet/layout/cwbvh_steps.h>
#include <treelet/layout/device_collapse.h>
#include <treelet/layout/layout_access.h>
#include <treelet/layout/wide_collapse_steps.h>

namespace treelet::cuda {

/// A tree and what is decided about its nodes.
struct WideEntries {
  const BinaryNode* nodes;
  SubtreeFaces faces;
  WideEntry* entries;

  /// Of an internal node.
  __device__ WideEntry& entry(const BinaryNode& node) const { return entries[node.left() / 2]; }

  __device__ WideDecision decision(const BinaryNode& node) const {
    return node.is_leaf() ? WideDecision::leaf() : entry(node).decision;
  }
  __device__ WideDecision decision(std::uint32_t slot) const { return decision(nodes[slot]); }

  /// Children of the node of the layout that the node above a pair of slots becomes.
  __device__ WideChildren children(std::uint32_t pair) const {
    return spread_over_children(WideSubtree{entries[pair].decision, 2 * pair},
                                [this](std::uint32_t slot) {
                                  const BinaryNode& node = nodes[slot];
                                  return WideSubtree{decision(node), node.left()};
                                });
  }

  /// The same in the slots of a CwbvhNode.
  __device__ CwbvhChildren arranged_children(std::uint32_t pair) const {
    const WideChildren children = this->children(pair);
    const Aabb box = merge(nodes[2 * pair].box(), nodes[2 * pair + 1].box());
    return arrange_children(children.slots.data(), int(children.count), box,
                            [this](std::uint32_t slot) { return nodes[slot].box(); });
  }

  /// What a child takes: a leaf no node.
  template <class Layout>
  __device__ WideEntry::Place size(std::uint32_t child) const {
    const BinaryNode& node = nodes[child];
    if (!decision(node).is_leaf) return entry(node).place;
    const std::uint32_t triangles = faces.count(node);
    return {0, blocks_for(triangles, kPositions<typename Layout::Item>), triangles, 0, 0, 0, 0};
  }
};

}  // namespace treelet::cuda
