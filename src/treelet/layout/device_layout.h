#pragma once

#include <cstdint>

#include <treelet/core/device_array.h>
#include <treelet/layout/bvh2.h>
#include <treelet/layout/bvh8.h>
#include <treelet/layout/cwbvh.h>

// Packed trees in device memory, byte for byte the host's.

namespace treelet::cuda {

/// What a packed tree takes or took. Lies in device memory.
struct LayoutSize {
  std::uint32_t nodes = 0;
  std::uint32_t items = 0;      ///< of bvh8: blocks; of the others: triangles
  std::uint32_t triangles = 0;  ///< in leaves: more than faces after splitting
  std::uint32_t depth = 0;      ///< nodes on the longest way from the root to a leaf
};

/// What a packed tree is, in device memory. A tree that did not fit its arrays has `overflowed` and
/// is empty: every ray misses it.
struct LayoutSummary {
  Aabb bounds;
  LayoutSize size;
  std::uint32_t overflowed;
  std::uint32_t hidden;  ///< triangles that the last refit had to hide (layout/refit_layout.h)
};

/// A packed tree in device memory that somebody else owns.
template <class NodeOf, class ItemOf>
struct DeviceLayout {
  using Node = NodeOf;
  using Item = ItemOf;
  static constexpr std::uint32_t kMaxItems = 0xffffffff;

  Node* nodes = nullptr;
  Item* items = nullptr;  ///< in leaf order
  std::uint32_t node_capacity = 0;
  std::uint32_t item_capacity = 0;
  LayoutSummary* summary = nullptr;
};

// Types of their own, whose names are those of kernels, too.
struct DeviceBvh2 : DeviceLayout<Bvh2Node, PackedTriangle> {};
struct DeviceBvh8 : DeviceLayout<Bvh8Node, TriangleBlock> {
  static constexpr std::uint32_t kMaxItems = WideChild::kMaxBlockIndex;
};
struct DeviceCwbvh : DeviceLayout<CwbvhNode, CwbvhTriangle> {};

/// Owns the arrays of one of these.
template <class Layout>
class LayoutStorage {
 public:
  LayoutStorage() = default;
  LayoutStorage(std::uint32_t node_capacity, std::uint32_t item_capacity, Stream stream)
      : nodes_(node_capacity, stream), items_(item_capacity, stream), summary_(1, stream) {}

  Layout view() {
    return {{nodes_.data(), items_.data(), std::uint32_t(nodes_.size()),
             std::uint32_t(items_.size()), summary_.data()}};
  }
  std::size_t bytes() const { return nodes_.bytes() + items_.bytes(); }
  void free_on(Stream stream) {
    nodes_.free_on(stream);
    items_.free_on(stream);
    summary_.free_on(stream);
  }

 private:
  DeviceArray<typename Layout::Node> nodes_;
  DeviceArray<typename Layout::Item> items_;
  DeviceArray<LayoutSummary> summary_;
};
using Bvh2Storage = LayoutStorage<DeviceBvh2>;
using Bvh8Storage = LayoutStorage<DeviceBvh8>;
using CwbvhStorage = LayoutStorage<DeviceCwbvh>;

/// Nodes that a tree over so many references has at most, whatever its leaves.
constexpr std::uint32_t max_layout_nodes(std::uint32_t references) {
  return references < 2 ? references : references - 1;
}

/// Copies to the host; waits for the copies. A tree that overflowed is empty.
Bvh2 download(const DeviceBvh2& bvh, Stream stream);
Bvh8 download(const DeviceBvh8& bvh, Stream stream);
Cwbvh download(const DeviceCwbvh& bvh, Stream stream);

}  // namespace treelet::cuda
