#include <treelet/layout/device_face_counts.h>

#include <treelet/core/launch.cuh>
#include <treelet/tree/subtree_levels.cuh>
#include <treelet/tree/top_levels.cuh>

// As on the host: each two neighbouring pieces of a face, in leaf order, are counted at their
// lowest common ancestor. A sort by face and place in leaf order makes them neighbours in memory,
// however many pieces a face has.

namespace treelet::cuda {
namespace {

constexpr unsigned kThreads = 256;

class FaceCounter {
 public:
  __device__ FaceCounter(const DeviceTree& tree, const FaceCountScratch& scratch,
                         const SubtreeFaces& faces)
      : tree_(tree), scratch_(scratch), faces_(faces) {}

  __device__ void place_children(std::uint32_t slot) const {
    const std::uint32_t pair = tree_.nodes[slot].left() / 2;
    faces_.above[pair] = slot;
    faces_.counts[pair] = 0;
    scratch_.begin[pair] = begin(slot);
  }

  __device__ void write_key(std::uint32_t slot, const Reference* pieces) const {
    const std::uint32_t piece = tree_.nodes[slot].index;
    scratch_.keys[piece] = std::uint64_t(pieces[piece].face) << 32 | begin(slot);
    scratch_.leaves[piece] = slot;
  }

  __device__ void write_last_key(std::uint32_t i) const {
    scratch_.keys[i] = ~std::uint64_t{0};
    scratch_.leaves[i] = 0;
  }

  /// Counts the leaf at place i > 0 of the sorted ones and the one before it.
  __device__ void count_pair(std::uint32_t i) const {
    const std::uint64_t left = scratch_.keys[i - 1], right = scratch_.keys[i];
    if (left >> 32 != right >> 32) return;
    std::uint32_t pair = scratch_.leaves[i] / 2;
    while (scratch_.begin[pair] > std::uint32_t(left)) pair = faces_.above[pair] / 2;
    atomicAdd(&faces_.counts[pair], 1u);
  }

  __device__ void add_children(std::uint32_t slot) const {
    const BinaryNode* nodes = tree_.nodes;
    const std::uint32_t left = nodes[slot].left(), pairs = faces_.counts[left / 2];
    faces_.counts[left / 2] = faces_.count(nodes[left]) + faces_.count(nodes[left + 1]) - pairs;
  }

 private:
  /// Leaves to the left of the subtree.
  __device__ std::uint32_t begin(std::uint32_t slot) const {
    if (slot == kRoot) return 0;
    return scratch_.begin[slot / 2] + (slot % 2 == 0 ? 0 : tree_.nodes[slot - 1].count);
  }

  const DeviceTree& tree_;
  const FaceCountScratch& scratch_;
  const SubtreeFaces& faces_;
};

__global__ void place_top_kernel(DeviceTree tree, DeviceCut cut, FaceCountScratch scratch,
                                 SubtreeFaces faces) {
  const FaceCounter counter(tree, scratch, faces);
  visit_top_top_down(cut, [&](std::uint32_t slot) { counter.place_children(slot); });
}

__global__ void place_subtrees_kernel(DeviceTree tree, DeviceCut cut, FaceCountScratch scratch,
                                      SubtreeFaces faces) {
  __shared__ SubtreeLevels levels;
  const FaceCounter counter(tree, scratch, faces);
  for_each_subtree(tree, cut, KeepAll{}, levels, [&] {
    visit_top_down(levels, [&](std::uint32_t slot) { counter.place_children(slot); });
  });
}

/// A thread a slot; and a thread a place that no reference takes, which sorts to the end.
__global__ void write_keys_kernel(DeviceTree tree, const Reference* pieces,
                                  FaceCountScratch scratch, SubtreeFaces faces) {
  const FaceCounter counter(tree, scratch, faces);
  const std::uint32_t i = thread_index(), count = *tree.reference_count;
  if (i < 2 * count && tree.nodes[i].is_leaf()) counter.write_key(i, pieces);
  if (i >= count && i < tree.capacity) counter.write_last_key(i);
}

__global__ void count_pairs_kernel(DeviceTree tree, FaceCountScratch scratch, SubtreeFaces faces) {
  const std::uint32_t i = thread_index();
  if (i == 0 || i >= *tree.reference_count) return;
  FaceCounter(tree, scratch, faces).count_pair(i);
}

__global__ void add_subtrees_kernel(DeviceTree tree, DeviceCut cut, FaceCountScratch scratch,
                                    SubtreeFaces faces) {
  __shared__ SubtreeLevels levels;
  const FaceCounter counter(tree, scratch, faces);
  for_each_subtree(tree, cut, KeepAll{}, levels, [&] {
    visit_bottom_up(levels, [&](std::uint32_t slot) { counter.add_children(slot); });
  });
}

__global__ void add_top_kernel(DeviceTree tree, DeviceCut cut, FaceCountScratch scratch,
                               SubtreeFaces faces) {
  const FaceCounter counter(tree, scratch, faces);
  visit_top_bottom_up(cut, [&](std::uint32_t slot) { counter.add_children(slot); });
}

}  // namespace

FaceCountScratch carve_face_count_scratch(Carver& carver, std::uint32_t capacity) {
  FaceCountScratch scratch;
  scratch.begin = carver.take<std::uint32_t>(capacity);
  scratch.keys = carver.take<std::uint64_t>(capacity);
  scratch.leaves = carver.take<std::uint32_t>(capacity);
  scratch.sort = carve_sort_scratch(carver, capacity);
  return scratch;
}

SubtreeFaces carve_subtree_faces(Carver& carver, std::uint32_t capacity) {
  return {carver.take<std::uint32_t>(capacity), carver.take<std::uint32_t>(capacity)};
}

void count_faces(const DeviceTree& tree, const DeviceCut& cut, const DeviceReferences& references,
                 const FaceCountScratch& scratch, const SubtreeFaces& faces, Stream stream) {
  const Grid subtrees{subtree_blocks(tree.capacity), kThreads}, top{1, kThreads};
  launch(stream, top, place_top_kernel, tree, cut, scratch, faces);
  launch(stream, subtrees, place_subtrees_kernel, tree, cut, scratch, faces);
  launch(stream, thread_each(2 * std::size_t(tree.capacity)), write_keys_kernel, tree,
         references.split, scratch, faces);
  sort_pairs(scratch.keys, scratch.leaves, tree.capacity, scratch.sort, stream);
  launch(stream, thread_each(tree.capacity), count_pairs_kernel, tree, scratch, faces);
  launch(stream, subtrees, add_subtrees_kernel, tree, cut, scratch, faces);
  launch(stream, top, add_top_kernel, tree, cut, scratch, faces);
}

}  // namespace treelet::cuda
