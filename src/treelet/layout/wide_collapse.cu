#include <treelet/layout/device_collapse.h>

#include <treelet/core/launch.cuh>
#include <treelet/layout/wide_entries.cuh>
#include <treelet/tree/subtree_levels.cuh>
#include <treelet/tree/top_levels.cuh>

namespace treelet::cuda {
namespace {

constexpr unsigned kThreads = 256;

/// Choices are made from below.
class ChoiceStep {
 public:
  __device__ ChoiceStep(const DeviceTree& tree, const SubtreeFaces& faces, WideEntry* entries)
      : nodes_(tree.nodes), tree_{tree.nodes, faces, entries} {}

  __device__ void choose(std::uint32_t slot, const WideCostModel& model) const {
    const BinaryNode node = nodes_[slot];
    const WideChoice left = choice_of(node.left(), model), right = choice_of(node.right(), model);
    const WideChoice choice =
        choose_internal(half_area(node.box()), tree_.faces.count(node), left, right, model);
    WideEntry& entry = tree_.entry(node);
    entry.decision = choice.decision;
    for (int i = 1; i < WideChoice::kWidth; ++i) entry.costs[i - 1] = choice.cost(i);
  }

 private:
  __device__ WideChoice choice_of(std::uint32_t slot, const WideCostModel& model) const {
    const BinaryNode node = nodes_[slot];
    if (node.is_leaf()) return choose_leaf(half_area(node.box()), model);
    const WideEntry entry = tree_.entry(node);
    WideChoice choice{entry.decision, {}};
    for (int i = 1; i < WideChoice::kWidth; ++i) choice.set_cost(i, entry.costs[i - 1]);
    return choice;
  }

  const BinaryNode* nodes_;
  WideEntries tree_;
};

/// Then the nodes of the layout are marked from above, measured from below and placed from above.
template <class Layout>
class PlaceStep {
 public:
  __device__ PlaceStep(const DeviceTree& tree, const SubtreeFaces& faces, WideEntry* entries)
      : nodes_(tree.nodes), tree_{tree.nodes, faces, entries} {}

  __device__ void mark_root() const {
    if (!tree_.decision(kRoot).is_leaf) tree_.entry(nodes_[kRoot]).decision.is_node = 1;
  }

  __device__ void mark_children(std::uint32_t slot) const {
    if (!is_node(slot)) return;
    for (const std::uint32_t child : children(slot)) {
      if (tree_.decision(child).is_leaf) continue;
      tree_.entry(nodes_[child]).decision.is_node = 1;
    }
  }

  __device__ void measure(std::uint32_t slot) const {
    if (!is_node(slot)) return;
    WideEntry::Place size{1, 0, 0, 0, 0, 0, 1};
    for (const std::uint32_t child : children(slot)) {
      const WideEntry::Place below = tree_.size<Layout>(child);
      size.nodes += below.nodes;
      size.blocks += below.blocks;
      size.triangles += below.triangles;
      size.height = size.height > below.height ? size.height : below.height;
    }
    ++size.height;
    tree_.entry(nodes_[slot]).place = size;
  }

  /// Places the root and says what the tree takes.
  __device__ LayoutSize place_root() const {
    const WideEntry::Place size = tree_.size<Layout>(kRoot);  // placed at 0
    if (size.nodes == 0) return {1, size.blocks, size.triangles, 1};
    return {size.nodes, size.blocks, size.triangles, size.height};
  }

  /// Places the children of a node of the layout that has been placed.
  __device__ void place_children(std::uint32_t slot) const {
    if (is_node(slot)) place_children(slot, Layout{});
  }

 private:
  /// Depth first.
  __device__ void place_children(std::uint32_t slot, DeviceBvh8) const {
    const WideEntry::Place& place = tree_.entry(nodes_[slot]).place;
    std::uint32_t node = place.first_node + 1, block = place.first_block;
    for (const std::uint32_t child : children(slot)) {
      const WideEntry::Place size = tree_.size<Layout>(child);
      if (size.nodes > 0) {
        tree_.entry(nodes_[child]).place.first_node = node;
        tree_.entry(nodes_[child]).place.first_block = block;
      }
      node += size.nodes;
      block += size.blocks;
    }
  }

  /// Depth first, but that children that are nodes lie side by side before all that is below them,
  /// and the triangles of leaves before those of nodes.
  __device__ void place_children(std::uint32_t slot, DeviceCwbvh) const {
    const WideEntry::Place& place = tree_.entry(nodes_[slot]).place;
    const CwbvhChildren children = tree_.arranged_children(nodes_[slot].left() / 2);
    std::uint32_t node = place.first_below, below = node, triangle = place.first_block;
    for (const std::uint32_t child : children.slots) {
      if (child == CwbvhChildren::kNone) continue;
      const WideEntry::Place size = tree_.size<Layout>(child);
      if (size.nodes > 0) {
        ++below;
      } else {
        triangle += size.triangles;
      }
    }
    for (const std::uint32_t child : children.slots) {
      if (child == CwbvhChildren::kNone || tree_.decision(child).is_leaf) continue;
      WideEntry::Place& size = tree_.entry(nodes_[child]).place;
      size.first_node = node++;
      size.first_below = below;
      size.first_block = triangle;
      below += size.nodes - 1;
      triangle += size.triangles;
    }
  }

  __device__ bool is_node(std::uint32_t slot) const {
    return tree_.entry(nodes_[slot]).decision.is_node;
  }

  __device__ WideChildren children(std::uint32_t slot) const {
    return tree_.children(nodes_[slot].left() / 2);
  }

  const BinaryNode* nodes_;
  WideEntries tree_;
};

template <class Step>
__device__ void mark_top(const DeviceTree& tree, const DeviceCut& cut, const Step& step) {
  if (threadIdx.x == 0 && *tree.reference_count > 0) step.mark_root();
  __syncthreads();
  visit_top_top_down(cut, [&](std::uint32_t slot) { step.mark_children(slot); });
}

template <class Step>
__device__ LayoutSize place_top(const DeviceTree& tree, const DeviceCut& cut, const Step& step) {
  visit_top_bottom_up(cut, [&](std::uint32_t slot) { step.measure(slot); });
  visit_top_top_down(cut, [&](std::uint32_t slot) { step.place_children(slot); });
  return threadIdx.x == 0 && *tree.reference_count > 0 ? step.place_root() : LayoutSize{};
}

__global__ void choose_subtrees_kernel(DeviceTree tree, DeviceCut cut, SubtreeFaces faces,
                                       WideCostModel model, WideEntry* entries) {
  __shared__ SubtreeLevels levels;
  const ChoiceStep step(tree, faces, entries);
  for_each_subtree(tree, cut, KeepAll{}, levels, [&] {
    visit_bottom_up(levels, [&](std::uint32_t slot) { step.choose(slot, model); });
  });
}

__global__ void choose_top_kernel(DeviceTree tree, DeviceCut cut, SubtreeFaces faces,
                                  WideCostModel model, WideEntry* entries) {
  const ChoiceStep step(tree, faces, entries);
  visit_top_bottom_up(cut, [&](std::uint32_t slot) { step.choose(slot, model); });
}

template <class Layout>
__global__ void mark_top_kernel(DeviceTree tree, DeviceCut cut, SubtreeFaces faces,
                                WideEntry* entries) {
  mark_top(tree, cut, PlaceStep<Layout>(tree, faces, entries));
}

template <class Layout>
__global__ void measure_subtrees_kernel(DeviceTree tree, DeviceCut cut, SubtreeFaces faces,
                                        WideEntry* entries) {
  __shared__ SubtreeLevels levels;
  const PlaceStep<Layout> step(tree, faces, entries);
  for_each_subtree(tree, cut, KeepAll{}, levels, [&] {
    visit_top_down(levels, [&](std::uint32_t slot) { step.mark_children(slot); });
    visit_bottom_up(levels, [&](std::uint32_t slot) { step.measure(slot); });
  });
}

template <class Layout>
__global__ void place_top_kernel(DeviceTree tree, DeviceCut cut, SubtreeFaces faces,
                                 WideEntry* entries, LayoutSize* size) {
  const LayoutSize total = place_top(tree, cut, PlaceStep<Layout>(tree, faces, entries));
  if (threadIdx.x == 0) *size = total;
}

template <class Layout>
__global__ void place_subtrees_kernel(DeviceTree tree, DeviceCut cut, SubtreeFaces faces,
                                      WideEntry* entries) {
  __shared__ SubtreeLevels levels;
  const PlaceStep<Layout> step(tree, faces, entries);
  for_each_subtree(tree, cut, KeepAll{}, levels, [&] {
    visit_top_down(levels, [&](std::uint32_t slot) { step.place_children(slot); });
  });
}

template <class Layout>
void place(const DeviceTree& tree, const DeviceCut& cut, const SubtreeFaces& faces,
           WideEntry* entries, LayoutSize* size, Stream stream) {
  const Grid subtrees{subtree_blocks(tree.capacity), kThreads}, top{1, kThreads};
  launch(stream, top, mark_top_kernel<Layout>, tree, cut, faces, entries);
  launch(stream, subtrees, measure_subtrees_kernel<Layout>, tree, cut, faces, entries);
  launch(stream, top, place_top_kernel<Layout>, tree, cut, faces, entries, size);
  launch(stream, subtrees, place_subtrees_kernel<Layout>, tree, cut, faces, entries);
}

}  // namespace

void choose_wide(const DeviceTree& tree, const DeviceCut& cut, const SubtreeFaces& faces,
                 const WideCostModel& model, WideEntry* entries, Stream stream) {
  const Grid subtrees{subtree_blocks(tree.capacity), kThreads};
  launch(stream, subtrees, choose_subtrees_kernel, tree, cut, faces, model, entries);
  launch(stream, Grid{1, kThreads}, choose_top_kernel, tree, cut, faces, model, entries);
}

void place_bvh8(const DeviceTree& tree, const DeviceCut& cut, const SubtreeFaces& faces,
                WideEntry* entries, LayoutSize* size, Stream stream) {
  place<DeviceBvh8>(tree, cut, faces, entries, size, stream);
}

void place_cwbvh(const DeviceTree& tree, const DeviceCut& cut, const SubtreeFaces& faces,
                 WideEntry* entries, LayoutSize* size, Stream stream) {
  place<DeviceCwbvh>(tree, cut, faces, entries, size, stream);
}

}  // namespace treelet::cuda
