#include <treelet/build/hploc.h>

#include <treelet/build/lbvh_steps.h>
#include <treelet/build/hploc.cuh>
#include <treelet/core/launch.cuh>
#include <treelet/primitive/device_references.cuh>

// As [Benthin2024 s3]. A thread begins at each leaf of the radix tree and climbs as in lbvh.cu: of
// two siblings the second to come goes on to the parent. Those lanes that have come to a node where
// clusters merge hand it to their warp, which takes one such node after the other, a cluster a
// lane:
//
//     lanes        0 1 2 3 4 5 6 ...    climb, each at a node of its own
//     ballot       . . x . . x . ...    come to nodes that merge
//     all lanes    2's node, then 5's:  load 16 + 16 clusters at most, merge, store 16 at most
//
// What a node does depends on its children's clusters alone, so it does not matter which warp takes
// it, or when.
//
// Counted for 200,000 random triangles and radius 8: a reference has 0.093 nodes that merge, which
// load 2.4 clusters, store 1.4 and take 0.19 rounds. Memory traffic a reference, in bytes, mostly
// of what is still in the cache: 52 read for its box, 40 written for its cluster; 24 of codes, 8
// exchanged; 86 of clusters read, 52 written, and 64 for the pair of a merge: some 330. In the code
// for sm_90 a node takes about 100 instructions of a warp, a round 120 and for each distance within
// the radius 38, 7 of which are shuffles; a step of the climb takes 100 for all lanes: with some 7
// steps a warp, 110 a reference. Surfaces of equal triangles merge in half as many rounds.

namespace treelet::cuda {
namespace {

constexpr std::uint32_t kNobody = ~0u;
constexpr unsigned kThreads = 128;

struct HplocBuild {
  DeviceReferences references;
  DeviceMortonOrder order;
  HplocScratch scratch;
  DeviceTree tree;
  int radius;
};

__device__ void make_cluster(const HplocBuild& build, std::uint32_t position, bool is_only) {
  const std::uint32_t index = build.order.references[position];
  const Reference reference = reference_of(build.references, index);
  const std::uint32_t slot = is_only ? kRoot : waiting_slot(position);
  store_node(build.tree.nodes + slot, {reference.lower, index, reference.upper, 1});
  if (is_only) store_node(build.tree.nodes + kRoot + 1, {});
  build.scratch.clusters[position] = position;
  build.scratch.far_ends[position] = kNobody;
}

__global__ void make_clusters(HplocBuild build) {
  const std::uint32_t position = thread_index(), count = *build.tree.reference_count;
  if (position < count) make_cluster(build, position, count == 1);
}

/// Orders memory between this thread and others of the device.
__device__ void fence() { __nv_atomic_thread_fence(__NV_ATOMIC_ACQ_REL, __NV_THREAD_SCOPE_DEVICE); }

/// A thread's way from a leaf of the radix tree up, for as long as it comes second.
class Climb {
 public:
  __device__ Climb(const RadixTreeView& keys, std::uint32_t* far_ends, std::uint32_t position)
      : keys_(keys), far_ends_(far_ends), goes_on_(position < keys.size() && keys.size() > 1) {
    if (goes_on_) range_ = leaf_range(keys_, position);
  }

  __device__ bool goes_on() const { return goes_on_; }

  __device__ void step() {
    goes_on_ = goes_on_ && !range_.is_root();
    if (!goes_on_) return;
    split_ = std::uint32_t(range_.parent_split());
    const std::uint32_t sibling_end = meet_sibling();
    goes_on_ = sibling_end != kNobody;
    if (goes_on_) range_ = parent_range(keys_, range_, sibling_end);
  }

  __device__ bool merges() const {
    return goes_on_ && merges_clusters(range_.last - range_.first + 1, keys_.size());
  }

  /// The meeting that a lane has come to; all lanes call.
  __device__ Meeting meeting_of(int lane) const {
    const auto get = [&](std::uint32_t value) { return __shfl_sync(kFullWarp, value, lane); };
    return {get(std::uint32_t(range_.first)), get(split_), get(std::uint32_t(range_.last))};
  }

 private:
  /// Says where the sibling's range ends, or kNobody to the first of the two.
  __device__ std::uint32_t meet_sibling() const {
    const auto mine = std::uint32_t(range_.is_left_child() ? range_.first : range_.last);
    return __nv_atomic_exchange_n(far_ends_ + split_, mine, __NV_ATOMIC_RELAXED,
                                  __NV_THREAD_SCOPE_DEVICE);
  }

  const RadixTreeView keys_;
  std::uint32_t* far_ends_;
  KeyRange range_{};
  std::uint32_t split_ = 0;
  bool goes_on_;
};

__device__ void merge_at(const HplocBuild& build, const Meeting& meeting, bool is_root) {
  WarpClusters clusters(build.tree.nodes, build.scratch.clusters);
  clusters.load(meeting);
  clusters.merge_until(is_root ? 1 : kHplocGoal, build.radius);
  is_root ? clusters.store_root() : clusters.store(meeting);
}

/// The warp merges where its lanes have come to, one lane after the other.
///
/// The lane that came second has found the end that the first one left by a relaxed exchange. Its
/// fence makes of that an acquire, and __syncwarp passes on to all lanes what it has in sight, as
/// shuffles and votes do not. Afterwards __syncwarp orders what all lanes have written before the
/// lane's second fence, which with its next exchange is a release; releases are cumulative, so that
/// the writes of all lanes are in sight of whoever acquires. Nodes that do not merge write nothing,
/// their clusters are there since the kernel before, and they need no fences: 19 of 20 exchanges.
__device__ void merge_in_turn(const HplocBuild& build, const Climb& climb, std::uint32_t count) {
  const bool merges = climb.merges();
  unsigned waiting = __ballot_sync(kFullWarp, merges);
  if (waiting == 0) return;
  if (merges) fence();
  __syncwarp();
  for (; waiting != 0; waiting &= waiting - 1) {
    const Meeting meeting = climb.meeting_of(__ffs(int(waiting)) - 1);
    merge_at(build, meeting, meeting.count() == count);
  }
  __syncwarp();
  if (merges) fence();
}

__global__ void __launch_bounds__(kThreads) climb_from_leaves(HplocBuild build) {
  const std::uint32_t count = *build.tree.reference_count;
  Climb climb({{build.order.codes, count}}, build.scratch.far_ends, thread_index());
  while (__any_sync(kFullWarp, climb.goes_on())) {
    climb.step();
    merge_in_turn(build, climb, count);
  }
}

}  // namespace

HplocScratch carve_hploc_scratch(Carver& carver, std::uint32_t capacity) {
  return {carver.take<std::uint32_t>(capacity), carver.take<std::uint32_t>(capacity)};
}

void build_hploc(const DeviceReferences& references, const DeviceMortonOrder& order,
                 const HplocConfig& config, const HplocScratch& scratch, const DeviceTree& tree,
                 Stream stream) {
  require_valid(config);
  const HplocBuild build{references, order, scratch, tree, config.radius};
  launch(stream, thread_each(tree.capacity, kThreads), make_clusters, build);
  launch(stream, thread_each(tree.capacity, kThreads), climb_from_leaves, build);
}

}  // namespace treelet::cuda
