#pragma once

#include <algorithm>
#include <cstdint>

#include <treelet/layout/device_layout.h>
#include <treelet/layout/device_pack.h>
#include <treelet/layout/device_refit_layout.h>
#include <treelet/layout/layout_access.h>
#include <treelet/layout/leaf_box_steps.h>
#include <treelet/tree/binary_tree.h>
#include <treelet/core/launch.cuh>

// What packing does alike for all layouts. A packer writes the nodes, but for their boxes, and for
// each leaf one word: in place of its first face, the slot of the binary tree that the leaf is.
// Then leaves write their faces, and a refit does the rest.

namespace treelet::cuda {

constexpr unsigned kPackThreads = 256;

template <class Layout, class Entry>
PackScratch<Layout, Entry> carve_pack_scratch(Carver& carver, std::uint32_t capacity) {
  PackScratch<Layout, Entry> scratch;
  scratch.size = carver.take<LayoutSize>(1);
  const std::size_t mark = carver.used();
  scratch.links = carver.take<LinkOf<Layout>>(max_layout_nodes(capacity));
  carver.rewind(mark);
  scratch.entries = carver.take<Entry>(capacity);
  return scratch;
}

/// Decides whether the planned layout fits, by one thread.
template <class Layout>
__global__ void begin_layout_kernel(Layout bvh, const LayoutSize* planned) {
  const bool fits = planned->nodes <= bvh.node_capacity && planned->items <= bvh.item_capacity &&
                    planned->items <= Layout::kMaxItems;
  *bvh.summary = {Aabb::empty(), fits ? *planned : LayoutSize{}, !fits, 0};
}

/// Thread i is about pair i; pair 0 is none.
template <class Writer, class Layout, class Entry>
__global__ void write_nodes_kernel(DeviceTree tree, SubtreeFaces faces, Entry* entries,
                                   Layout bvh) {
  const std::uint32_t pair = thread_index();
  if (pair >= *tree.reference_count || bvh.summary->size.nodes == 0) return;
  const Writer writer(tree, faces, entries, bvh);
  if (pair == 0) {
    writer.write_single_leaf();
  } else {
    writer.write_node(pair);
  }
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
template <std::uint32_t kMostReferences>
struct WholeTriangleLeaves {
  const BinaryNode* nodes;

  template <class Item, class Node>
  __device__ void write(Item* items, Node& node, int child) const {
    const PositionRange leaf = leaf_positions(node, child);
    const std::uint32_t slot = face_at(items, leaf.begin);
    std::uint32_t position = leaf.begin;
    visit_references<kMostReferences>(
        nodes, slot, [&](std::uint32_t reference) { face_at(items, position++) = reference; });
    while (position < leaf.end) face_at(items, position++) = TriangleBlock::kNoFace;
  }
};

/// Writes the faces of a leaf of pieces, each once, and the box that its pieces have in mesh units.
struct PieceLeaves {
  const BinaryNode* nodes;
  SubtreeFaces faces;
  DeviceReferences references;

  template <class Item, class Node>
  __device__ void write(Item* items, Node& node, int child) const {
    const PositionRange leaf = leaf_positions(node, child);
    const std::uint32_t root = face_at(items, leaf.begin);
    leave_box(items, node, child, root);
    const std::uint32_t end = leaf.begin + faces.count(nodes[root]);
    std::uint32_t position = leaf.begin;
    for (std::uint32_t slot = first_leaf(root); position < end; slot = next_leaf(slot)) {
      const std::uint32_t face = references.split[nodes[slot].index].face;
      if (!has_face(items, leaf.begin, position, face)) face_at(items, position++) = face;
    }
    while (position < leaf.end) face_at(items, position++) = TriangleBlock::kNoFace;
  }

 private:
  __device__ std::uint32_t first_leaf(std::uint32_t slot) const {
    while (!nodes[slot].is_leaf()) slot = nodes[slot].left();
    return slot;
  }

  /// A leaf may have any number of pieces: no stack would be large enough.
  __device__ std::uint32_t next_leaf(std::uint32_t slot) const {
    while (slot % 2 != 0) slot = faces.above[slot / 2];
    return first_leaf(slot + 1);
  }

  template <class Item>
  __device__ static bool has_face(const Item* items, std::uint32_t begin, std::uint32_t end,
                                  std::uint32_t face) {
    for (std::uint32_t i = begin; i < end; ++i) {
      if (face_at(items, i) == face) return true;
    }
    return false;
  }

  /// Leaves the box where fit_pieces finds it. Where splitting has added nothing it cuts nothing
  /// off: these boxes hold whole triangles.
  template <class Item, class Node>
  __device__ void leave_box(Item*, Node& node, int child, std::uint32_t slot) const {
    const double scale = power_of_two(references.scene->scale_exponent);
    set_child_box(node, child, to_mesh_units(nodes[slot].box(), scale));
  }
  __device__ void leave_box(CwbvhTriangle* items, CwbvhNode& node, int child,
                            std::uint32_t slot) const {
    items[node.triangle(child)].reserved1 = slot;
  }
};

/// A thread a child.
template <class Leaves, class Layout>
__global__ void write_leaves_kernel(Layout bvh, Leaves leaves) {
  constexpr unsigned kLanes = kChildren<typename Layout::Node>;
  const std::uint32_t index = blockIdx.x * (kPackThreads / kLanes) + threadIdx.x / kLanes;
  if (index >= bvh.summary->size.nodes) return;
  typename Layout::Node& node = bvh.nodes[index];
  const int child = int(threadIdx.x % kLanes);
  if (is_leaf_child(node, child)) leaves.write(bvh.items, node, child);
}

template <class Leaves, class Layout>
void write_leaves(const Layout& bvh, const Leaves& leaves, Stream stream) {
  constexpr std::size_t kLanes = kChildren<typename Layout::Node>;
  launch(stream, thread_each(bvh.node_capacity * kLanes, kPackThreads),
         write_leaves_kernel<Leaves, Layout>, bvh, leaves);
}

template <class Layout>
void fit_pieces(const Layout& bvh, const PackInput& input, NodeLink* links, Stream stream) {
  fit_pieces(bvh, input.references.mesh, links, stream);
}
inline void fit_pieces(const DeviceCwbvh& bvh, const PackInput& input, BoxLink* links,
                       Stream stream) {
  fit_pieces(bvh, input.references.mesh, {input.tree.nodes, input.references.scene}, links, stream);
}

/// Enqueues what remains to be done when the nodes are written.
template <std::uint32_t kMostReferences, class Layout>
void finish_layout(const Layout& bvh, const PackInput& input, LinkOf<Layout>* links,
                   Stream stream) {
  const DeviceTree& tree = input.tree;
  Layout written = bvh;  // a large capacity needs no more threads than the tree may need
  written.node_capacity = std::min(bvh.node_capacity, max_layout_nodes(tree.capacity));
  if (input.references.split == nullptr) {
    write_leaves(written, WholeTriangleLeaves<kMostReferences>{tree.nodes}, stream);
    return refit(written, input.references.mesh, links, stream);
  }
  write_leaves(written, PieceLeaves{tree.nodes, input.faces, input.references}, stream);
  fit_pieces(written, input, links, stream);
}

/// Enqueues the whole second call of a packer.
template <class Writer, std::uint32_t kMostReferences, class Layout, class Entry>
void write_layout(const PackInput& input, const PackScratch<Layout, Entry>& scratch,
                  const Layout& bvh, Stream stream) {
  launch(stream, Grid{1, 1}, begin_layout_kernel<Layout>, bvh, scratch.size);
  launch(stream, thread_each(input.tree.capacity, kPackThreads),
         write_nodes_kernel<Writer, Layout, Entry>, input.tree, input.faces, scratch.entries, bvh);
  finish_layout<kMostReferences>(bvh, input, scratch.links, stream);
}

}  // namespace treelet::cuda
