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
    node.child[0] = write_leaf(kRoot, 0, tree_.size(kRoot).blocks);
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
      const WideEntry::Place size = tree_.size(slot);
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

/// Thread i is about pair i; pair 0 is none.
__global__ void write_nodes_kernel(DeviceTree tree, SubtreeFaces faces, WideEntry* entries,
                                   DeviceBvh8 bvh) {
  const std::uint32_t pair = thread_index();
  if (pair >= *tree.reference_count || bvh.summary->size.nodes == 0) return;
  const Bvh8Writer writer(tree, faces, entries, bvh);
  if (pair == 0) {
    writer.write_single_leaf();
  } else {
    writer.write_node(pair);
  }
}

}  // namespace

Bvh8Scratch carve_bvh8_scratch(Carver& carver, std::uint32_t capacity) {
  Bvh8Scratch scratch;
  scratch.size = carver.take<LayoutSize>(1);
  const std::size_t mark = carver.used();
  scratch.links = carve_links(carver, max_layout_nodes(capacity));
  carver.rewind(mark);
  scratch.entries = carver.take<WideEntry>(capacity);
  return scratch;
}

void plan_bvh8(const PackInput& input, const WideCostModel& model, const Bvh8Scratch& scratch,
               Stream stream) {
  if (model.leaf_limit < 1 || model.leaf_limit > kMaxBvh8Leaf) {
    throw std::invalid_argument("leaves of bvh8 hold 1 to " + std::to_string(kMaxBvh8Leaf) +
                                " triangles, not " + std::to_string(model.leaf_limit));
  }
  choose_wide(input.tree, input.cut, input.faces, model, scratch.entries, stream);
  place_wide(input.tree, input.cut, input.faces, scratch.entries, scratch.size, stream);
}

void write_bvh8(const PackInput& input, const Bvh8Scratch& scratch, const DeviceBvh8& bvh,
                Stream stream) {
  launch(stream, Grid{1, 1}, begin_layout_kernel<DeviceBvh8>, bvh, scratch.size);
  launch(stream, thread_each(input.tree.capacity, kPackThreads), write_nodes_kernel, input.tree,
         input.faces, scratch.entries, bvh);
  finish_layout<kMaxBvh8Leaf>(bvh, input, scratch.links, stream);
}

}  // namespace treelet::cuda
