#include <treelet/layout/device_collapse.h>

#include <treelet/core/launch.cuh>
#include <treelet/layout/wide_entries.cuh>
#include <treelet/tree/subtree_levels.cuh>
#include <treelet/tree/top_levels.cuh>

namespace treelet::cuda {
namespace {

constexpr unsigned kThreads = 256;

/// First all choices are made, from below; then the nodes of the layout are marked from above,
/// measured from below and placed from above.
class WideCollapseStep {
 public:
  __device__ WideCollapseStep(const DeviceTree& tree, const SubtreeFaces& faces, WideEntry* entries)
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
    WideEntry::Place size{1, 0, 0, 0, 0, 0};
    for (const std::uint32_t child : children(slot)) {
      const WideEntry::Place below = tree_.size(child);
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
    const WideEntry::Place size = tree_.size(kRoot);  // placed at 0
    if (size.nodes == 0) return {1, size.blocks, size.triangles, 1};
    return {size.nodes, size.blocks, size.triangles, size.height};
  }

  /// Places the children of a node of the layout that has been placed.
  __device__ void place_children(std::uint32_t slot) const {
    if (!is_node(slot)) return;
    const WideEntry::Place& place = tree_.entry(nodes_[slot]).place;
    std::uint32_t node = place.first_node + 1, block = place.first_block;
    for (const std::uint32_t child : children(slot)) {
      const WideEntry::Place size = tree_.size(child);
      if (size.nodes > 0) {
        tree_.entry(nodes_[child]).place.first_node = node;
        tree_.entry(nodes_[child]).place.first_block = block;
      }
      node += size.nodes;
      block += size.blocks;
    }
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

  __device__ bool is_node(std::uint32_t slot) const {
    return tree_.entry(nodes_[slot]).decision.is_node;
  }

  __device__ WideChildren children(std::uint32_t slot) const {
    return tree_.children(nodes_[slot].left() / 2);
  }

  const BinaryNode* nodes_;
  WideEntries tree_;
};

/// Calls work(levels) for each subtree, a block a subtree.
template <class Work>
__device__ void for_each_subtree(const DeviceTree& tree, const DeviceCut& cut,
                                 SubtreeLevels& levels, Work work) {
  for (std::uint32_t s = blockIdx.x; s < cut.counts->subtrees; s += gridDim.x) {
    list_levels(tree.nodes, cut.subtrees[s], [](const BinaryNode&) { return true; }, levels);
    work();
  }
}

__device__ void mark_top(const DeviceTree& tree, const DeviceCut& cut,
                         const WideCollapseStep& step) {
  if (threadIdx.x == 0 && *tree.reference_count > 0) step.mark_root();
  __syncthreads();
  visit_top_top_down(cut, [&](std::uint32_t slot) { step.mark_children(slot); });
}

__device__ LayoutSize place_top(const DeviceTree& tree, const DeviceCut& cut,
                                const WideCollapseStep& step) {
  visit_top_bottom_up(cut, [&](std::uint32_t slot) { step.measure(slot); });
  visit_top_top_down(cut, [&](std::uint32_t slot) { step.place_children(slot); });
  return threadIdx.x == 0 && *tree.reference_count > 0 ? step.place_root() : LayoutSize{};
}

__global__ void choose_subtrees_kernel(DeviceTree tree, DeviceCut cut, SubtreeFaces faces,
                                       WideCostModel model, WideEntry* entries) {
  __shared__ SubtreeLevels levels;
  const WideCollapseStep step(tree, faces, entries);
  for_each_subtree(tree, cut, levels, [&] {
    visit_bottom_up(levels, [&](std::uint32_t slot) { step.choose(slot, model); });
  });
}

__global__ void choose_top_kernel(DeviceTree tree, DeviceCut cut, SubtreeFaces faces,
                                  WideCostModel model, WideEntry* entries) {
  const WideCollapseStep step(tree, faces, entries);
  visit_top_bottom_up(cut, [&](std::uint32_t slot) { step.choose(slot, model); });
}

__global__ void mark_top_kernel(DeviceTree tree, DeviceCut cut, SubtreeFaces faces,
                                WideEntry* entries) {
  mark_top(tree, cut, WideCollapseStep(tree, faces, entries));
}

__global__ void measure_subtrees_kernel(DeviceTree tree, DeviceCut cut, SubtreeFaces faces,
                                        WideEntry* entries) {
  __shared__ SubtreeLevels levels;
  const WideCollapseStep step(tree, faces, entries);
  for_each_subtree(tree, cut, levels, [&] {
    visit_top_down(levels, [&](std::uint32_t slot) { step.mark_children(slot); });
    visit_bottom_up(levels, [&](std::uint32_t slot) { step.measure(slot); });
  });
}

__global__ void place_top_kernel(DeviceTree tree, DeviceCut cut, SubtreeFaces faces,
                                 WideEntry* entries, LayoutSize* size) {
  const LayoutSize total = place_top(tree, cut, WideCollapseStep(tree, faces, entries));
  if (threadIdx.x == 0) *size = total;
}

__global__ void place_subtrees_kernel(DeviceTree tree, DeviceCut cut, SubtreeFaces faces,
                                      WideEntry* entries) {
  __shared__ SubtreeLevels levels;
  const WideCollapseStep step(tree, faces, entries);
  for_each_subtree(tree, cut, levels, [&] {
    visit_top_down(levels, [&](std::uint32_t slot) { step.place_children(slot); });
  });
}

}  // namespace

void choose_wide(const DeviceTree& tree, const DeviceCut& cut, const SubtreeFaces& faces,
                 const WideCostModel& model, WideEntry* entries, Stream stream) {
  const Grid subtrees{subtree_blocks(tree.capacity), kThreads};
  launch(stream, subtrees, choose_subtrees_kernel, tree, cut, faces, model, entries);
  launch(stream, Grid{1, kThreads}, choose_top_kernel, tree, cut, faces, model, entries);
}

void place_wide(const DeviceTree& tree, const DeviceCut& cut, const SubtreeFaces& faces,
                WideEntry* entries, LayoutSize* size, Stream stream) {
  const Grid subtrees{subtree_blocks(tree.capacity), kThreads}, top{1, kThreads};
  launch(stream, top, mark_top_kernel, tree, cut, faces, entries);
  launch(stream, subtrees, measure_subtrees_kernel, tree, cut, faces, entries);
  launch(stream, top, place_top_kernel, tree, cut, faces, entries, size);
  launch(stream, subtrees, place_subtrees_kernel, tree, cut, faces, entries);
}

}  // namespace treelet::cuda
