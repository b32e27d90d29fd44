#pragma once

#include <algorithm>
#include <cstdint>

#include <treelet/layout/device_layout.h>
#include <treelet/layout/device_refit_layout.h>
#include <treelet/layout/layout_access.h>
#include <treelet/tree/binary_tree.h>
#include <treelet/core/launch.cuh>

// What packing does alike for both layouts. A packer writes the nodes, but for their boxes, and for
// each leaf one word: in place of its first face, the slot of the binary tree that the leaf is.
// Then leaves write their faces, and a refit does the rest.

namespace treelet::cuda {

constexpr unsigned kPackThreads = 256;

/// Decides whether the planned layout fits, by one thread.
template <class Layout>
__global__ void begin_layout_kernel(Layout bvh, const LayoutSize* planned) {
  const bool fits = planned->nodes <= bvh.node_capacity && planned->items <= bvh.item_capacity &&
                    planned->items <= Layout::kMaxItems;
  *bvh.summary = {Aabb::empty(), fits ? *planned : LayoutSize{}, !fits, 0};
}

/// Calls visit(reference) for the references of a leaf, left to right. A leaf of n references has
/// at most n - 1 subtrees waiting.
template <std::uint32_t kMostReferences, class Visit>
__device__ void visit_references(const BinaryNode* nodes, std::uint32_t leaf, Visit visit) {
  std::uint32_t waiting[kMostReferences];
  std::uint32_t count = 0;
  waiting[count++] = leaf;
  while (count > 0) {
    BinaryNode node = nodes[waiting[--count]];
    while (!node.is_leaf()) {
      waiting[count++] = node.right();
      node = nodes[node.left()];
    }
    visit(node.index);
  }
}

/// Writes the faces of a leaf: of an unsplit tree, its references.
template <std::uint32_t kMostReferences, class Item>
__device__ void write_faces(const BinaryNode* nodes, Item* items, const PositionRange& leaf) {
  const std::uint32_t slot = face_at(items, leaf.begin);
  std::uint32_t position = leaf.begin;
  visit_references<kMostReferences>(
      nodes, slot, [&](std::uint32_t reference) { face_at(items, position++) = reference; });
  while (position < leaf.end) face_at(items, position++) = TriangleBlock::kNoFace;
}

/// A thread a child.
template <std::uint32_t kMostReferences, class Layout>
__global__ void write_faces_kernel(Layout bvh, const BinaryNode* nodes) {
  constexpr unsigned kLanes = kChildren<typename Layout::Node>;
  const std::uint32_t index = blockIdx.x * (kPackThreads / kLanes) + threadIdx.x / kLanes;
  if (index >= bvh.summary->size.nodes) return;
  const typename Layout::Node& node = bvh.nodes[index];
  const int child = int(threadIdx.x % kLanes);
  if (!is_leaf_child(node, child)) return;
  write_faces<kMostReferences>(nodes, bvh.items, leaf_positions(node, child));
}

/// Enqueues what remains to be done when the nodes are written.
template <std::uint32_t kMostReferences, class Layout>
void finish_layout(const Layout& bvh, const DeviceTree& tree, const DeviceMesh& mesh,
                   NodeLink* links, Stream stream) {
  constexpr std::size_t kLanes = kChildren<typename Layout::Node>;
  Layout written = bvh;  // a large capacity needs no more threads than the tree may need
  written.node_capacity = std::min(bvh.node_capacity, max_layout_nodes(tree.capacity));
  launch(stream, thread_each(written.node_capacity * kLanes, kPackThreads),
         write_faces_kernel<kMostReferences, Layout>, written, tree.nodes);
  refit(written, mesh, links, stream);
}

}  // namespace treelet::cuda
