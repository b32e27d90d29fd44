#pragma once

#include <cstdint>

#include <treelet/core/stream.h>
#include <treelet/layout/device_layout.h>
#include <treelet/primitive/device_references.h>
#include <treelet/tree/binary_tree.h>

namespace treelet::cuda {

/// What a node needs to know while boxes are fitted from below; 8 bytes a node.
struct NodeLink {
  std::uint32_t parent;   ///< of no meaning for the root
  std::uint32_t arrived;  ///< node children that have their boxes, and the leaf children as one
};

/// The same for a node that does not hold its children's boxes as they are: 32 bytes a node.
struct alignas(16) BoxLink {
  std::uint32_t parent;
  std::uint32_t arrived;
  Aabb box;  ///< of the node: of its leaves until it is complete
};
static_assert(sizeof(BoxLink) == 32);

template <class Layout>
struct LinkOfLayout {
  using Link = NodeLink;
};
template <>
struct LinkOfLayout<DeviceCwbvh> {
  using Link = BoxLink;
};
template <class Layout>
using LinkOf = typename LinkOfLayout<Layout>::Link;

/// Where the boxes of leaves of pieces come from: a binary tree in build space.
struct PieceBoxes {
  const BinaryNode* nodes;
  const DeviceScene* scene;
};

/// As refit on the host (layout/refit_layout.h): triangles go to where the mesh has their faces
/// now, boxes fit again. Also counts the hidden triangles in the summary. `links` is scratch for as
/// many nodes as the layout has capacity.
void refit(const DeviceBvh2& bvh, const DeviceMesh& mesh, NodeLink* links, Stream stream);
void refit(const DeviceBvh8& bvh, const DeviceMesh& mesh, NodeLink* links, Stream stream);
void refit(const DeviceCwbvh& bvh, const DeviceMesh& mesh, BoxLink* links, Stream stream);

/// The same, but that each leaf keeps of its new box what lies in the box it comes with: how a
/// leaf of pieces gets its first box.
void fit_pieces(const DeviceBvh2& bvh, const DeviceMesh& mesh, NodeLink* links, Stream stream);
void fit_pieces(const DeviceBvh8& bvh, const DeviceMesh& mesh, NodeLink* links, Stream stream);

/// A leaf of this layout has no room for such a box. It comes with the slot that it is of the
/// binary tree, in the first reserved word of its first triangle.
void fit_pieces(const DeviceCwbvh& bvh, const DeviceMesh& mesh, const PieceBoxes& pieces,
                BoxLink* links, Stream stream);

}  // namespace treelet::cuda
