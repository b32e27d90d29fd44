#include <treelet/optimize/treelet.h>

#include <algorithm>
#include <stdexcept>
#include <string>

#include <treelet/core/launch.cuh>
#include <treelet/optimize/treelet_top.cuh>
#include <treelet/optimize/warp_treelet.cuh>
#include <treelet/tree/subtree_levels.cuh>

namespace treelet::cuda {
namespace {

constexpr unsigned kWarps = 8;
constexpr unsigned kThreads = kWarps * kWarpSize;
/// Blocks to a multiprocessor at least: 64 registers a thread, 80 for treelets of eight.
template <int Size>
constexpr unsigned kBlocks = Size < 8 ? 4 : 3;
constexpr unsigned kListThreads = 512;

/// The rounds of a run.
struct Rounds {
  std::uint32_t gamma;  // of the first
  int count;
};

/// As on the host a round needs gamma references, and none comes after one that finds too few. Only
/// the device knows the references, but larger gammas than theirs find no root.
Rounds plan_rounds(const TreeletConfig& config, std::uint32_t capacity) {
  Rounds rounds{config.gamma == 0 ? std::uint32_t(config.size) : config.gamma, 0};
  for (std::uint64_t gamma = rounds.gamma; gamma <= capacity && rounds.count < config.rounds;
       gamma *= 2) {
    ++rounds.count;
  }
  return rounds;
}

/// All rounds of a subtree below the cut, by one block.
template <int Size>
class SubtreeRestructuring {
 public:
  __device__ SubtreeRestructuring(const DeviceTree& tree, const SahModel& sah, float* costs,
                                  SubtreeLevels& levels, TreeletScratch<Size>& scratch)
      : nodes_(tree.nodes),
        costs_(costs, sah),
        levels_(levels),
        warp_(tree.nodes, costs, sah, scratch) {}

  __device__ void run(std::uint32_t root, const Rounds& rounds) {
    list(root, kAllInternal);
    visit_bottom_up(levels_, [this](std::uint32_t slot) { costs_.update(nodes_, slot); });
    for (int round = 0; round < rounds.count; ++round) {
      list(root, rounds.gamma << round);
      visit_bottom_up_by_warps(levels_, [this](std::uint32_t slot) { warp_.restructure(slot); });
    }
  }

 private:
  __device__ void list(std::uint32_t root, std::uint32_t min_count) {
    list_levels(
        nodes_, root, [=](const BinaryNode& node) { return node.count >= min_count; }, levels_);
  }

  BinaryNode* nodes_;
  PairCosts costs_;
  SubtreeLevels& levels_;
  WarpRestructuring<Size> warp_;
};

template <int Size>
__global__ void __launch_bounds__(kThreads, kBlocks<Size>)
    restructure_subtrees(DeviceTree tree, SahModel sah, Rounds rounds, TreeletBuffers buffers) {
  __shared__ SubtreeLevels levels;
  __shared__ TreeletScratch<Size> scratch[kWarps];
  SubtreeRestructuring<Size> work(tree, sah, buffers.costs, levels,
                                  scratch[threadIdx.x / kWarpSize]);
  for_each_subtree(buffers.cut, [&](std::uint32_t root) { work.run(root, rounds); });
}

__global__ void list_roots(DeviceTree tree, std::uint32_t min_count, TopRoots roots) {
  __shared__ BreadthFirstScratch scratch;
  const std::uint32_t count = *tree.reference_count < min_count
                                  ? 0  // perhaps of no references: not even the root is read
                                  : list_top_roots(tree, min_count, roots, scratch);
  if (threadIdx.x == 0) *roots.count = count;
}

template <int Size>
__global__ void __launch_bounds__(kThreads, kBlocks<Size>)
    restructure_top(DeviceTree tree, SahModel sah, TreeletBuffers buffers) {
  __shared__ TreeletScratch<Size> scratch[kWarps];
  WarpRestructuring<Size> warp(tree.nodes, buffers.costs, sah, scratch[threadIdx.x / kWarpSize]);
  climb_top(buffers.top, [&](std::uint32_t slot) { warp.restructure(slot); });
}

__global__ void update_top_costs(DeviceTree tree, SahModel sah, TreeletBuffers buffers) {
  const PairCosts costs(buffers.costs, sah);
  climb_top(buffers.top, [&](std::uint32_t slot) {
    if (lane_index() == 0) costs.update(tree.nodes, slot);
  });
}

/// Of the nodes above the cut a warp takes a few at most, unless they make a chain.
Grid top_grid(const DeviceTree& tree) {
  return {subtree_blocks(tree.capacity) / kWarps + 1, kThreads};
}

template <int Size>
void restructure_subtrees_and_top(const DeviceTree& tree, const SahModel& sah, const Rounds& rounds,
                                  const TreeletBuffers& buffers, Stream stream) {
  if (rounds.count == 0) return;
  cut_tree(tree, buffers.cut, stream);
  launch(stream, {subtree_blocks(tree.capacity), kThreads}, restructure_subtrees<Size>, tree, sah,
         rounds, buffers);
  if (tree.capacity <= kSubtreeReferences) return;
  const auto list = [&](std::uint32_t min_count) {
    launch(stream, {1, kListThreads}, list_roots, tree, min_count, buffers.top);
  };
  constexpr std::uint32_t kSmallest = kSubtreeReferences + 1;
  if (rounds.gamma > kSmallest) {  // else the first round comes by all nodes
    list(kSmallest);
    launch(stream, top_grid(tree), update_top_costs, tree, sah, buffers);
  }
  for (int round = 0; round < rounds.count; ++round) {
    list(std::max(rounds.gamma << round, kSmallest));  // anew: a round moves the cut
    launch(stream, top_grid(tree), restructure_top<Size>, tree, sah, buffers);
  }
}

}  // namespace

TreeletBuffers carve_treelet_buffers(Carver& carver, std::uint32_t capacity) {
  const std::size_t top = max_top_nodes(capacity);
  TreeletBuffers buffers;
  buffers.costs = carver.take<float>(capacity);
  const std::size_t mark = carver.used();
  buffers.top = {carver.take<std::uint32_t>(top), carver.take<std::uint32_t>(top),
                 carver.take<std::uint32_t>(top), carver.take<std::uint32_t>(1)};
  carver.rewind(mark);
  buffers.cut = carve_cut(carver, capacity);  // no smaller than top: what comes next lies behind
  return buffers;
}

void restructure_treelets(const DeviceTree& tree, const SahModel& sah, const TreeletConfig& config,
                          const TreeletBuffers& buffers, Stream stream) {
  const Rounds rounds = plan_rounds(config, tree.capacity);
  switch (config.size) {
    case 4:
      return restructure_subtrees_and_top<4>(tree, sah, rounds, buffers, stream);
    case 5:
      return restructure_subtrees_and_top<5>(tree, sah, rounds, buffers, stream);
    case 6:
      return restructure_subtrees_and_top<6>(tree, sah, rounds, buffers, stream);
    case 7:
      return restructure_subtrees_and_top<7>(tree, sah, rounds, buffers, stream);
    case 8:
      return restructure_subtrees_and_top<8>(tree, sah, rounds, buffers, stream);
  }
  throw std::invalid_argument("treelets have 4 to 8 leaves, not " + std::to_string(config.size));
}

}  // namespace treelet::cuda
