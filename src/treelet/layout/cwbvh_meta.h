#pragma once

#include <cstdint>

#include <treelet/layout/cwbvh.h>

namespace treelet {

/// Whether a slot says without contradiction that it is empty, a node or a leaf.
inline bool has_sound_meta(const CwbvhNode& node, int slot) {
  if (node.is_node(slot)) return node.meta[slot] == CwbvhNode::node_meta(slot);
  if (node.is_none(slot)) return true;
  const std::uint32_t count = node.triangle_count(slot), offset = node.meta[slot] & 31u;
  return count > 0 && offset + count <= CwbvhNode::kNodeOffset &&
         node.meta[slot] == CwbvhNode::leaf_meta(offset, count);
}

}  // namespace treelet
