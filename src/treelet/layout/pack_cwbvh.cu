#include <treelet/layout/device_pack.h>

#include <treelet/layout/pack_layout.cuh>
#include <treelet/layout/wide_entries.cuh>

namespace treelet::cuda {
namespace {

/// Writes nodes without grids and planes, and of each leaf its slot.
class CwbvhWriter {
 public:
  __device__ CwbvhWriter(const DeviceTree& tree, const SubtreeFaces& faces, WideEntry* entries,
                         const DeviceCwbvh& bvh)
      : tree_{tree.nodes, faces, entries}, bvh_(bvh) {}

  /// The root, where it has a single leaf.
  __device__ void write_single_leaf() const {
    if (!tree_.decision(kRoot).is_leaf) return;
    CwbvhNodeFiller filler(bvh_.nodes[0], 1, 0);
    add_leaf(filler, 0, kRoot);
  }

  /// The node above a pair of slots, where it is a node of the layout.
  __device__ void write_node(std::uint32_t pair) const {
    const WideEntry& entry = tree_.entries[pair];
    if (!entry.decision.is_node) return;
    const CwbvhChildren children = tree_.arranged_children(pair);
    const WideEntry::Place& place = entry.place;
    CwbvhNodeFiller filler(bvh_.nodes[place.first_node], place.first_below, place.first_block);
    for (int i = 0; i < CwbvhNode::kChildren; ++i) {
      const std::uint32_t slot = children.slots[i];
      if (slot == CwbvhChildren::kNone) continue;
      if (tree_.decision(slot).is_leaf) {
        add_leaf(filler, i, slot);
      } else {
        filler.add_node(i);
      }
    }
  }

 private:
  __device__ void add_leaf(CwbvhNodeFiller& filler, int i, std::uint32_t slot) const {
    const std::uint32_t triangles = tree_.size<DeviceCwbvh>(slot).triangles;
    const std::uint32_t first = filler.add_leaf(i, triangles);
    for (std::uint32_t k = 0; k < triangles; ++k) bvh_.items[first + k] = {};
    face_at(bvh_.items, first) = slot;
  }

  WideEntries tree_;
  const DeviceCwbvh& bvh_;
};

}  // namespace

CwbvhScratch carve_cwbvh_scratch(Carver& carver, std::uint32_t capacity) {
  return carve_pack_scratch<DeviceCwbvh, WideEntry>(carver, capacity);
}

void plan_cwbvh(const PackInput& input, const CwbvhCostModel& model, const CwbvhScratch& scratch,
                Stream stream) {
  const WideCostModel wide = model.checked();
  choose_wide(input.tree, input.cut, input.faces, wide, scratch.entries, stream);
  place_cwbvh(input.tree, input.cut, input.faces, scratch.entries, scratch.size, stream);
}

void write_cwbvh(const PackInput& input, const CwbvhScratch& scratch, const DeviceCwbvh& bvh,
                 Stream stream) {
  write_layout<CwbvhWriter, CwbvhNode::kMaxLeaf>(input, scratch, bvh, stream);
}

}  // namespace treelet::cuda
