#pragma once

#include <cstdint>

#include <treelet/layout/device_collapse.h>
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

  /// What a child takes: a leaf no node.
  __device__ WideEntry::Place size(std::uint32_t child) const {
    const BinaryNode& node = nodes[child];
    const std::uint32_t triangles = faces.count(node);
    if (decision(node).is_leaf) return {0, blocks_for(triangles), triangles, 0, 0, 0};
    return entry(node).place;
  }
};

}  // namespace treelet::cuda
