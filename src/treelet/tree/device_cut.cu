#include <treelet/tree/device_cut.h>

#include <treelet/core/launch.cuh>
#include <treelet/tree/breadth_first.cuh>

namespace treelet::cuda {
namespace {

constexpr unsigned kThreads = 512;

/// Walks the nodes above the cut. Of the 2 * place + 2 children that have been met when node
/// `place` has been expanded, those that are not on top are subtrees.
class CutWalk {
 public:
  __device__ explicit CutWalk(const DeviceCut& cut) : cut_(cut) {}

  __device__ void run(const BinaryNode* nodes, BreadthFirstScratch& scratch) {
    top_ = walk_breadth_first(
        nodes, kRoot, cut_.top, scratch,
        [](const BinaryNode& node) { return node.count > kSubtreeReferences; },
        [this](std::uint32_t place, const BinaryNode& node, const ListedChildren& children) {
          list_subtrees(place, node, children);
        },
        [this](std::uint32_t end) { end_level(end); });
    if (top_ == 0 && threadIdx.x == 0) cut_.subtrees[0] = kRoot;
  }

  /// A full binary tree has one leaf more than internal nodes.
  __device__ DeviceCutCounts counts() const { return {top_ + 1, top_, depth_}; }

 private:
  __device__ void list_subtrees(std::uint32_t place, const BinaryNode& node,
                                const ListedChildren& children) const {
    // Before this node's children, 2 * place others were met, and of them all on the list but the
    // root are on top.
    std::uint32_t next = 2 * place - (children.place - 1);
    if (!children.left) cut_.subtrees[next++] = node.left();
    if (!children.right) cut_.subtrees[next] = node.right();
  }

  __device__ void end_level(std::uint32_t end) {
    ++depth_;
    if (threadIdx.x == 0) cut_.top_ends[depth_] = end;
  }

  const DeviceCut& cut_;
  std::uint32_t top_ = 0;
  std::uint32_t depth_ = 0;
};

__device__ DeviceCutCounts cut_by_block(const DeviceTree& tree, const DeviceCut& cut,
                                        BreadthFirstScratch& scratch) {
  if (*tree.reference_count == 0) return {0, 0, 0};
  CutWalk walk(cut);
  walk.run(tree.nodes, scratch);
  return walk.counts();
}

__global__ void cut_kernel(DeviceTree tree, DeviceCut cut) {
  __shared__ BreadthFirstScratch scratch;
  const DeviceCutCounts counts = cut_by_block(tree, cut, scratch);
  if (threadIdx.x > 0) return;
  cut.top_ends[0] = 0;
  *cut.counts = counts;
}

}  // namespace

DeviceCut carve_cut(Carver& carver, std::uint32_t capacity) {
  const std::size_t top = max_top_nodes(capacity);
  return {carver.take<std::uint32_t>(top + 1), carver.take<std::uint32_t>(top),
          carver.take<std::uint32_t>(top + 1), carver.take<DeviceCutCounts>(1)};
}

void cut_tree(const DeviceTree& tree, const DeviceCut& cut, Stream stream) {
  launch(stream, Grid{1, kThreads}, cut_kernel, tree, cut);
}

}  // namespace treelet::cuda
