#include <treelet/layout/device_pack.h>

#include <stdexcept>
#include <string>

#include <treelet/layout/pack_layout.cuh>

namespace treelet::cuda {
namespace {

/// Writes nodes without their boxes, and of each leaf its slot.
class Bvh2Writer {
 public:
  __device__ Bvh2Writer(const DeviceTree& tree, const SubtreeFaces& faces, const LeafEntry* entries,
                        const DeviceBvh2& bvh)
      : nodes_(tree.nodes), faces_(faces), entries_(entries), bvh_(bvh) {}

  __device__ void write_single_leaf() const {
    const BinaryNode& root = nodes_[kRoot];
    if (!root.is_leaf() && !entry(root).is_leaf) return;
    Bvh2Node& node = bvh_.nodes[0];
    node.box[1] = Aabb::empty();
    node.index = {0, 0};
    node.count = {faces_.count(root), 0};
    face_at(bvh_.items, 0) = kRoot;
  }

  /// The node whose children are a pair of slots, where it is a node of the layout.
  __device__ void write_node(std::uint32_t pair) const {
    const LeafEntry placed = entries_[pair];
    if (placed.first_triangle == LeafEntry::kNowhere) return;
    Bvh2Node& node = bvh_.nodes[placed.first_node];
    write_child(node, 0, 2 * pair, placed.first_triangle);
    write_child(node, 1, 2 * pair + 1, placed.first_triangle + faces_.count(nodes_[2 * pair]));
  }

 private:
  __device__ const LeafEntry& entry(const BinaryNode& node) const {
    return entries_[node.left() / 2];
  }

  __device__ void write_child(Bvh2Node& node, int i, std::uint32_t slot,
                              std::uint32_t first_triangle) const {
    const BinaryNode& child = nodes_[slot];
    const bool is_leaf = child.is_leaf() || entry(child).is_leaf;
    node.index[i] = is_leaf ? first_triangle : entry(child).first_node;
    node.count[i] = is_leaf ? faces_.count(child) : 0;
    if (is_leaf) face_at(bvh_.items, first_triangle) = slot;
  }

  const BinaryNode* nodes_;
  const SubtreeFaces faces_;
  const LeafEntry* entries_;
  const DeviceBvh2& bvh_;
};

}  // namespace

Bvh2Scratch carve_bvh2_scratch(Carver& carver, std::uint32_t capacity) {
  return carve_pack_scratch<DeviceBvh2, LeafEntry>(carver, capacity);
}

void plan_bvh2(const PackInput& input, const SahModel& sah, const Bvh2Scratch& scratch,
               Stream stream) {
  if (sah.leaf_limit < 1 || sah.leaf_limit > kMaxBvh2Leaf) {
    throw std::invalid_argument("leaves of bvh2 hold 1 to " + std::to_string(kMaxBvh2Leaf) +
                                " triangles on the device, not " + std::to_string(sah.leaf_limit));
  }
  collapse_leaves(input.tree, input.cut, input.faces, sah, scratch.entries, scratch.size, stream);
}

void write_bvh2(const PackInput& input, const Bvh2Scratch& scratch, const DeviceBvh2& bvh,
                Stream stream) {
  write_layout<Bvh2Writer, kMaxBvh2Leaf>(input, scratch, bvh, stream);
}

}  // namespace treelet::cuda
