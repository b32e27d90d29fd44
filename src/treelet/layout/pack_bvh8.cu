#include <treelet/layout/device_pack.h>

#include <stdexcept>
#include <string>

#include <treelet/layout/pack_layout.cuh>
#include <treelet/layout/wide_entries.cuh>

namespace treelet::cuda {
namespace {

constexpr std::uint32_t kMaxBvh8Leaf = WideChild::kMaxBlocks * TriangleBlock::kTriangles;

/// Writes nodes, their boxes empty, and of each leaf its slot.
class Bvh8Writer {
 public:
  __device__ Bvh8Writer(const DeviceTree& tree, const SubtreeFaces& faces, WideEntry* entries,
                        const DeviceBvh8& bvh)
      : tree_{tree.nodes, faces, entries}, bvh_(bvh) {}

  /// The root, where it has a single leaf.
  __device__ void write_single_leaf() const {
    if (!tree_.decision(kRoot).is_leaf) return;
    Bvh8Node& node = clear_node(0);
    node.child[0] = write_leaf(kRoot, 0, tree_.size<DeviceBvh8>(kRoot).blocks);
  }

  /// The node above a pair of slots, where it is a node of the layout.
  __device__ void write_node(std::uint32_t pair) const {
    const WideEntry& entry = tree_.entries[pair];
    if (!entry.decision.is_node) return;
    const WideChildren children = tree_.children(pair);
    Bvh8Node& node = clear_node(entry.place.first_node);
    std::uint32_t block = entry.place.first_block;
    for (std::uint32_t i = 0; i < children.count; ++i) {
      const std::uint32_t slot = children.slots[i];
      const WideEntry::Place size = tree_.size<DeviceBvh8>(slot);
      node.child[i] =
          size.nodes > 0 ? WideChild::node(size.first_node) : write_leaf(slot, block, size.blocks);
      block += size.blocks;
    }
  }

 private:
  __device__ Bvh8Node& clear_node(std::uint32_t index) const {
    Bvh8Node& node = bvh_.nodes[index];
    for (int i = 0; i < Bvh8Node::kChildren; ++i) {
      node.set_box(i, Aabb::empty());
      node.child[i] = {WideChild::kNone};
      node.reserved[i] = 0;
    }
    return node;
  }

  __device__ WideChild write_leaf(std::uint32_t slot, std::uint32_t block,
                                  std::uint32_t blocks) const {
    bvh_.items[block].face[0] = slot;
    return WideChild::leaf(block, blocks);
  }

  WideEntries tree_;
  const DeviceBvh8& bvh_;
};

}  // namespace

Bvh8Scratch carve_bvh8_scratch(Carver& carver, std::uint32_t capacity) {
  return carve_pack_scratch<DeviceBvh8, WideEntry>(carver, capacity);
}

void plan_bvh8(const PackInput& input, const WideCostModel& model, const Bvh8Scratch& scratch,
               Stream stream) {
  if (model.leaf_limit < 1 || model.leaf_limit > kMaxBvh8Leaf) {
    throw std::invalid_argument("leaves of bvh8 hold 1 to " + std::to_string(kMaxBvh8Leaf) +
                                " triangles, not " + std::to_string(model.leaf_limit));
  }
  choose_wide(input.tree, input.cut, input.faces, model, scratch.entries, stream);
  place_bvh8(input.tree, input.cut, input.faces, scratch.entries, scratch.size, stream);
}

void write_bvh8(const PackInput& input, const Bvh8Scratch& scratch, const DeviceBvh8& bvh,
                Stream stream) {
  write_layout<Bvh8Writer, kMaxBvh8Leaf>(input, scratch, bvh, stream);
}

}  // namespace treelet::cuda
