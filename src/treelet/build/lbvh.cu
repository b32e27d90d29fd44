#include <treelet/build/lbvh.h>

#include <treelet/build/lbvh_steps.h>
#include <treelet/core/device_memory.h>
#include <treelet/core/launch.cuh>
#include <treelet/primitive/device_references.cuh>

// Emission and refit in one way up [Apetrei2014 s3]. A thread begins at each leaf. It writes its
// node and leaves the far end of the node's range in the word of the split between the node and its
// sibling. The first of the two to come there ends; the second finds the sibling's end, which makes
// the parent's range, and the sibling's box, which makes the parent's box:
//
//     keys:    a  b  c | d  e        the word between c and d holds the end `a`, left by the node
//              |<----->| |<->|       over a..c, or the end `e`, left by the node over d..e
//
// The parent splits where it was put together, so its place and children are those of the host's
// top-down search (lbvh_steps.h), whoever comes first.
//
// Memory traffic a reference, in bytes: 64 written to nodes, each once; 32 of a sibling read again,
// mostly while still in the cache; 4 of a word set, 8 exchanged; 12 of codes and order; 48 of face
// and vertices, or 32 of a split reference; and an internal node reads a code at either side of its
// new end, 16.
//
// Differs from [Karras2012 s4]: no second pass over the tree, no parent links, no binary searches.

namespace treelet::cuda {
namespace {

constexpr std::uint32_t kNobody = ~0u;
constexpr unsigned char kNobodyByte = 0xff;

struct LbvhBuild {
  DeviceReferences references;
  DeviceMortonOrder order;
  std::uint32_t* far_ends;
  DeviceTree tree;
};

__device__ BinaryNode make_leaf(const LbvhBuild& build, std::uint32_t position) {
  const std::uint32_t index = build.order.references[position];
  const Reference reference = reference_of(build.references, index);
  return {reference.lower, index, reference.upper, 1};
}

/// Says in which range the sibling ends, or kNobody to the first of the two. What the first wrote
/// before is visible to the second.
__device__ std::uint32_t meet_sibling(const LbvhBuild& build, const KeyRange& range) {
  const auto mine = std::uint32_t(range.is_left_child() ? range.first : range.last);
  return __nv_atomic_exchange_n(build.far_ends + range.parent_split(), mine, __NV_ATOMIC_ACQ_REL,
                                __NV_THREAD_SCOPE_DEVICE);
}

__device__ BinaryNode make_parent(std::uint32_t left_slot, const BinaryNode& left,
                                  const BinaryNode& right) {
  const Aabb box = merge(left.box(), right.box());
  return {box.lower, left_slot, box.upper, left.count + right.count};
}

__device__ void climb(const LbvhBuild& build, const RadixTreeView& keys, std::uint32_t position) {
  KeyRange range = leaf_range(keys, position);
  BinaryNode node = make_leaf(build, position);
  while (!range.is_root()) {
    const std::uint32_t slot = range.slot();
    build.tree.nodes[slot] = node;
    const std::uint32_t sibling_end = meet_sibling(build, range);
    if (sibling_end == kNobody) return;
    const BinaryNode sibling = build.tree.nodes[slot ^ 1];
    node = range.is_left_child() ? make_parent(slot, node, sibling)
                                 : make_parent(slot ^ 1, sibling, node);
    range = parent_range(keys, range, sibling_end);
  }
  build.tree.nodes[kRoot] = node;
  build.tree.nodes[kRoot + 1] = {};
}

__global__ void climb_from_leaves(LbvhBuild build) {
  const std::uint32_t position = thread_index(), count = *build.tree.reference_count;
  if (position >= count) return;
  climb(build, {{build.order.codes, count}}, position);
}

}  // namespace

LbvhScratch carve_lbvh_scratch(Carver& carver, std::uint32_t capacity) {
  return {carver.take<std::uint32_t>(capacity), capacity};
}

void build_lbvh(const DeviceReferences& references, const DeviceMortonOrder& order,
                const LbvhScratch& scratch, const DeviceTree& tree, Stream stream) {
  if (tree.capacity == 0) return;
  fill_device_bytes(scratch.far_ends, kNobodyByte, scratch.capacity * sizeof(*scratch.far_ends),
                    stream);
  const LbvhBuild build{references, order, scratch.far_ends, tree};
  launch(stream, thread_each(tree.capacity), climb_from_leaves, build);
}

}  // namespace treelet::cuda
