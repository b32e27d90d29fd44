#pragma once

#include <cstdint>

#include <treelet/core/carver.h>
#include <treelet/core/stream.h>
#include <treelet/layout/device_layout.h>
#include <treelet/primitive/device_references.h>

namespace treelet::cuda {

/// What a node needs to know while boxes are fitted from below; 8 bytes a node.
struct NodeLink {
  std::uint32_t parent;   ///< of no meaning for the root
  std::uint32_t arrived;  ///< node children that have their boxes, and the leaf children as one
};

inline NodeLink* carve_links(Carver& carver, std::uint32_t node_capacity) {
  return carver.take<NodeLink>(node_capacity);
}

/// As refit on the host (layout/refit_layout.h): triangles go to where the mesh has their faces
/// now, boxes fit again. Also counts the hidden triangles in the summary. `links` is scratch for as
/// many nodes as the layout has capacity.
void refit(const DeviceBvh2& bvh, const DeviceMesh& mesh, NodeLink* links, Stream stream);
void refit(const DeviceBvh8& bvh, const DeviceMesh& mesh, NodeLink* links, Stream stream);

/// The same, but that each leaf keeps of its new box what lies in the box it comes with: how a
/// leaf of pieces gets its first box.
void fit_pieces(const DeviceBvh2& bvh, const DeviceMesh& mesh, NodeLink* links, Stream stream);
void fit_pieces(const DeviceBvh8& bvh, const DeviceMesh& mesh, NodeLink* links, Stream stream);

}  // namespace treelet::cuda
