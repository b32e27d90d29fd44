#include <treelet/layout/device_collapse.h>

#include <treelet/layout/leaf_collapse_steps.h>
#include <treelet/core/launch.cuh>
#include <treelet/tree/subtree_levels.cuh>
#include <treelet/tree/top_levels.cuh>

namespace treelet::cuda {
namespace {

constexpr unsigned kThreads = 256;

/// The tree and what is decided about its nodes.
class LeafCollapseStep {
 public:
  __device__ LeafCollapseStep(const DeviceTree& tree, const SubtreeFaces& faces, LeafEntry* entries)
      : nodes_(tree.nodes), faces_(faces), entries_(entries) {}

  __device__ bool is_leaf(const BinaryNode& node) const {
    return node.is_leaf() || entry(node).is_leaf;
  }

  __device__ void decide(std::uint32_t slot, const SahModel& sah) const {
    const BinaryNode node = nodes_[slot], left = nodes_[node.left()], right = nodes_[node.right()];
    const LeafEntry a = entry_of(left, sah), b = entry_of(right, sah);
    const LeafDecision decision =
        decide_leaf(half_area(node.box()), a.cost + b.cost, faces_.count(node), sah);
    LeafEntry decided;
    decided.cost = decision.cost;
    decided.is_leaf = decision.is_leaf;
    decided.nodes = decision.is_leaf ? 0 : (1 + a.nodes + b.nodes) & 0x7fffffff;
    decided.height = decision.is_leaf ? 0 : 1 + (a.height > b.height ? a.height : b.height);
    decided.first_triangle = LeafEntry::kNowhere;
    entry(node) = decided;
    if (faces_.counts != nullptr && !decision.is_leaf) {
      faces_.counts[node.left() / 2] = faces_.count(left) + faces_.count(right);
    }
  }

  /// Places the children of a node that has been placed.
  __device__ void place_children(std::uint32_t slot) const {
    const BinaryNode node = nodes_[slot], left = nodes_[node.left()], right = nodes_[node.right()];
    const LeafEntry placed = entry(node);
    const std::uint32_t left_nodes = left.is_leaf() ? 0 : entry(left).nodes;
    place(left, placed.first_node + 1, placed.first_triangle);
    place(right, placed.first_node + 1 + left_nodes, placed.first_triangle + faces_.count(left));
  }

  /// Places the root and says what the tree takes.
  __device__ LayoutSize place_root() const {
    const BinaryNode root = nodes_[kRoot];
    const std::uint32_t triangles = faces_.count(root);
    if (is_leaf(root)) return {1, triangles, triangles, 1};
    place(root, 0, 0);
    return {entry(root).nodes, triangles, triangles, entry(root).height};
  }

 private:
  __device__ LeafEntry& entry(const BinaryNode& node) const { return entries_[node.left() / 2]; }

  __device__ LeafEntry entry_of(const BinaryNode& node, const SahModel& sah) const {
    if (!node.is_leaf()) return entry(node);
    LeafEntry leaf{};
    leaf.cost = sah.leaf_cost(half_area(node.box()), 1);
    return leaf;
  }

  __device__ void place(const BinaryNode& node, std::uint32_t first_node,
                        std::uint32_t first_triangle) const {
    if (is_leaf(node)) return;
    entry(node).first_node = first_node;
    entry(node).first_triangle = first_triangle;
  }

  const BinaryNode* nodes_;
  const SubtreeFaces faces_;
  LeafEntry* entries_;
};

__device__ LayoutSize collapse_top(const DeviceTree& tree, const DeviceCut& cut,
                                   const SahModel& sah, const LeafCollapseStep& step) {
  if (*tree.reference_count == 0) return {};
  visit_top_bottom_up(cut, [&](std::uint32_t slot) { step.decide(slot, sah); });
  LayoutSize size;
  if (threadIdx.x == 0) size = step.place_root();
  __syncthreads();
  visit_top_top_down(cut, [&](std::uint32_t slot) { step.place_children(slot); });
  return size;
}

__global__ void decide_subtrees_kernel(DeviceTree tree, DeviceCut cut, SubtreeFaces faces,
                                       SahModel sah, LeafEntry* entries) {
  __shared__ SubtreeLevels levels;
  const LeafCollapseStep step(tree, faces, entries);
  for_each_subtree(tree, cut, KeepAll{}, levels, [&] {
    visit_bottom_up(levels, [&](std::uint32_t slot) { step.decide(slot, sah); });
  });
}

__global__ void collapse_top_kernel(DeviceTree tree, DeviceCut cut, SubtreeFaces faces,
                                    SahModel sah, LeafEntry* entries, LayoutSize* size) {
  const LayoutSize total = collapse_top(tree, cut, sah, LeafCollapseStep(tree, faces, entries));
  if (threadIdx.x == 0) *size = total;
}

__global__ void place_subtrees_kernel(DeviceTree tree, DeviceCut cut, SubtreeFaces faces,
                                      LeafEntry* entries) {
  __shared__ SubtreeLevels levels;
  const LeafCollapseStep step(tree, faces, entries);
  const auto stays_node = [&](const BinaryNode& node) { return !step.is_leaf(node); };
  for_each_subtree(tree, cut, stays_node, levels, [&] {
    visit_top_down(levels, [&](std::uint32_t slot) { step.place_children(slot); });
  });
}

}  // namespace

void collapse_leaves(const DeviceTree& tree, const DeviceCut& cut, const SubtreeFaces& faces,
                     const SahModel& sah, LeafEntry* entries, LayoutSize* size, Stream stream) {
  const Grid subtrees{subtree_blocks(tree.capacity), kThreads};
  launch(stream, subtrees, decide_subtrees_kernel, tree, cut, faces, sah, entries);
  launch(stream, Grid{1, kThreads}, collapse_top_kernel, tree, cut, faces, sah, entries, size);
  launch(stream, subtrees, place_subtrees_kernel, tree, cut, faces, entries);
}

}  // namespace treelet::cuda
