#include <treelet/layout/device_epo.h>

#include <algorithm>

#include <treelet/core/device_array.h>
#include <treelet/layout/epo_steps.h>
#include <treelet/core/launch.cuh>

namespace treelet::cuda {
namespace {

constexpr std::uint32_t kNone = 0xffffffff;
constexpr unsigned kThreads = 128;

/// Positions of faces as lists, in whose order nothing depends on: a split face has several.
struct FaceLists {
  std::uint32_t* first;  // by face; kNone where it is in no leaf
  std::uint32_t* next;   // by position
  std::uint32_t face_count;

  __device__ void add(std::uint32_t face, std::uint32_t position) const {
    next[position] = atomicExch(&first[face], position);
  }
  /// Whether one of the positions of the list that begins with `position` is in a range.
  __device__ bool meets(std::uint32_t position, const PositionRange& range) const {
    while (position != kNone && !(range.begin <= position && position < range.end)) {
      position = next[position];
    }
    return position != kNone;
  }
};

/// The faces that are in leaves, numbered without gaps; each by the first position of its list.
struct FaceRanks {
  std::uint32_t* first;   // by rank
  std::uint32_t* starts;  // by range of kEpoGrain faces: faces in leaves before it
  std::uint32_t* count;   // of ranks

  __device__ void count_range(const FaceLists& lists, std::uint32_t range) const {
    std::uint32_t found = 0;
    for_each_face(lists, range, [&](std::uint32_t) { ++found; });
    starts[range] = found;
  }
  __device__ void scan_starts(std::uint32_t ranges) const {
    std::uint32_t sum = 0;
    for (std::uint32_t i = 0; i < ranges; ++i) {
      const std::uint32_t found = starts[i];
      starts[i] = sum;
      sum += found;
    }
    *count = sum;
  }
  __device__ void write_range(const FaceLists& lists, std::uint32_t range) const {
    std::uint32_t rank = starts[range];
    for_each_face(lists, range, [&](std::uint32_t position) { first[rank++] = position; });
  }

 private:
  template <class Visit>
  __device__ static void for_each_face(const FaceLists& lists, std::uint32_t range, Visit visit) {
    const std::uint32_t begin = range * kEpoGrain;  // the last range may be empty
    const std::uint32_t rest = lists.face_count - begin;
    const std::uint32_t end = begin + (rest < kEpoGrain ? rest : kEpoGrain);
    for (std::uint32_t face = begin; face < end; ++face) {
      if (lists.first[face] != kNone) visit(lists.first[face]);
    }
  }
};

/// Which ranks are measured, for the number of ranks that only the device knows.
struct Samples {
  const std::uint32_t* rank_count;
  std::uint32_t limit;

  __device__ std::uint32_t count() const { return *rank_count < limit ? *rank_count : limit; }
  __device__ std::uint32_t rank(std::uint32_t i) const {
    return std::uint32_t(std::uint64_t(i) * *rank_count / count());
  }
};

/// The first position in the subtree of a node.
template <class Node>
__device__ std::uint32_t first_position(const Node* nodes, std::uint32_t index) {
  while (is_node_child(nodes[index], 0)) index = node_index(nodes[index], 0);
  return leaf_positions(nodes[index], 0).begin;
}

/// The position behind the last in the subtree of a node.
template <class Node>
__device__ std::uint32_t end_position(const Node* nodes, std::uint32_t index) {
  while (true) {
    const Node& node = nodes[index];
    int last = kChildren<Node> - 1;
    while (!is_leaf_child(node, last) && !is_node_child(node, last)) --last;
    if (is_leaf_child(node, last)) return leaf_positions(node, last).end;
    index = node_index(node, last);
  }
}

__device__ std::uint32_t first_position(const CwbvhNode* nodes, std::uint32_t index) {
  return nodes[index].first_triangle;
}

/// The nodes of a node come behind its leaves.
__device__ std::uint32_t end_position(const CwbvhNode* nodes, std::uint32_t index) {
  const auto last = [&](auto&& is_sought) {
    int slot = CwbvhNode::kChildren - 1;
    while (!is_sought(nodes[index], slot)) --slot;
    return slot;
  };
  while (nodes[index].node_mask != 0) {
    index = nodes[index].node(last([](const CwbvhNode& node, int i) { return node.is_node(i); }));
  }
  const int leaf = last([](const CwbvhNode& node, int i) { return node.is_leaf(i); });
  return leaf_positions(nodes[index], leaf).end;
}

template <class Node, class Item>
__device__ EpoAreas measure(const EpoTree<Node, Item>& tree, const SahModel& sah,
                            const FaceLists& lists, std::uint32_t position) {
  const auto is_at_home = [&](const PositionRange& range) { return lists.meets(position, range); };
  return EpoWalk(tree, sah, triangle_at(tree.items, position), is_at_home).run();
}

template <class Layout>
__global__ void list_positions_kernel(Layout bvh, FaceLists lists) {
  const std::uint32_t position = thread_index();
  if (position >= bvh.summary->size.items * kPositions<typename Layout::Item>) return;
  const std::uint32_t face = face_at(bvh.items, position);
  if (face != TriangleBlock::kNoFace) lists.add(face, position);
}

template <class Layout>
__global__ void describe_subtrees_kernel(Layout bvh, EpoSubtree* subtrees) {
  const std::uint32_t node = thread_index();
  if (node >= bvh.summary->size.nodes) return;
  subtrees[node].range = {first_position(bvh.nodes, node), end_position(bvh.nodes, node)};
  link_children(bvh.nodes, node, subtrees);
}

__global__ void count_ranks_kernel(FaceLists lists, FaceRanks ranks, std::uint32_t ranges) {
  if (thread_index() < ranges) ranks.count_range(lists, thread_index());
}

__global__ void scan_ranks_kernel(FaceRanks ranks, std::uint32_t ranges) {
  ranks.scan_starts(ranges);
}

__global__ void write_ranks_kernel(FaceLists lists, FaceRanks ranks, std::uint32_t ranges) {
  if (thread_index() < ranges) ranks.write_range(lists, thread_index());
}

template <class Layout>
__global__ void measure_kernel(Layout bvh, const EpoSubtree* subtrees, SahModel sah,
                               FaceLists lists, FaceRanks ranks, Samples samples, EpoAreas* areas) {
  const std::uint32_t i = thread_index();
  if (i >= samples.count()) return;
  const EpoTree<typename Layout::Node, typename Layout::Item> tree{bvh.nodes, bvh.items, subtrees,
                                                                   bvh.summary->size.nodes};
  areas[i] = measure(tree, sah, lists, ranks.first[samples.rank(i)]);
}

__device__ EpoAreas sum_range(const EpoAreas* areas, std::uint32_t begin, std::uint32_t end) {
  EpoAreas sum;
  for (std::uint32_t i = begin; i < end; ++i) sum = sum + areas[i];
  return sum;
}

__global__ void sum_ranges_kernel(const EpoAreas* areas, Samples samples, EpoAreas* partial) {
  const std::uint32_t begin = thread_index() * kEpoGrain, count = samples.count();
  if (begin >= count) return;
  partial[thread_index()] =
      sum_range(areas, begin, count - begin < kEpoGrain ? count : begin + kEpoGrain);
}

__global__ void sum_partial_kernel(const EpoAreas* partial, Samples samples, double* epo) {
  const std::uint32_t count = samples.count();
  const EpoAreas sum = sum_range(partial, 0, count / kEpoGrain + (count % kEpoGrain != 0));
  *epo = sum.surface > 0.0 ? sum.overlap / sum.surface : 0.0;
}

/// Memory of its own, and what is enqueued with it.
template <class Layout>
class EndPointOverlap {
 public:
  EndPointOverlap(const Layout& bvh, std::uint32_t face_count, Stream stream)
      : bvh_(bvh),
        stream_(stream),
        face_count_(face_count),
        ranges_(face_count / kEpoGrain + 1),
        positions_(std::size_t(bvh.item_capacity) * kPositions<typename Layout::Item>),
        words_(2 * std::size_t(face_count) + positions_ + ranges_ + 1, stream),
        subtrees_(bvh.node_capacity, stream),
        areas_(face_count, stream),
        partial_(ranges_, stream),
        epo_(1, stream) {
    lists_ = {words_.data(), words_.data() + face_count, face_count};
    ranks_.first = lists_.next + positions_;
    ranks_.starts = ranks_.first + face_count;
    ranks_.count = ranks_.starts + ranges_;
  }

  double compute(const SahModel& sah, std::uint32_t limit) {
    number_faces();
    launch(stream_, thread_each(bvh_.node_capacity, kThreads), describe_subtrees_kernel<Layout>,
           bvh_, subtrees_.data());
    const Samples samples{ranks_.count, limit};
    launch(stream_, thread_each(std::min(face_count_, limit), kThreads), measure_kernel<Layout>,
           bvh_, subtrees_.data(), sah, lists_, ranks_, samples, areas_.data());
    launch(stream_, thread_each(ranges_, kThreads), sum_ranges_kernel, areas_.data(), samples,
           partial_.data());
    launch(stream_, Grid{1, 1}, sum_partial_kernel, partial_.data(), samples, epo_.data());
    return download(epo_)[0];
  }

 private:
  void number_faces() {
    fill_device_bytes(lists_.first, 0xff, face_count_ * sizeof *lists_.first, stream_);
    launch(stream_, thread_each(positions_, kThreads), list_positions_kernel<Layout>, bvh_, lists_);
    const Grid each_range = thread_each(ranges_, kThreads);
    launch(stream_, each_range, count_ranks_kernel, lists_, ranks_, ranges_);
    launch(stream_, Grid{1, 1}, scan_ranks_kernel, ranks_, ranges_);
    launch(stream_, each_range, write_ranks_kernel, lists_, ranks_, ranges_);
  }

  const Layout bvh_;
  const Stream stream_;
  const std::uint32_t face_count_;
  const std::uint32_t ranges_;  // of kEpoGrain faces
  const std::size_t positions_;
  DeviceArray<std::uint32_t> words_;
  DeviceArray<EpoSubtree> subtrees_;
  DeviceArray<EpoAreas> areas_;
  DeviceArray<EpoAreas> partial_;
  DeviceArray<double> epo_;
  FaceLists lists_;
  FaceRanks ranks_;
};

template <class Layout>
double compute(const Layout& bvh, const SahModel& sah, std::uint32_t face_count, Stream stream,
               std::size_t max_triangles) {
  if (face_count == 0) return 0.0;
  const std::size_t limit = max_triangles == 0 ? face_count : max_triangles;
  return EndPointOverlap<Layout>(bvh, face_count, stream)
      .compute(sah, std::uint32_t(std::min<std::size_t>(limit, face_count)));
}

}  // namespace

double compute_epo(const DeviceBvh2& bvh, const SahModel& sah, std::uint32_t face_count,
                   Stream stream, std::size_t max_triangles) {
  return compute(bvh, sah, face_count, stream, max_triangles);
}
double compute_epo(const DeviceBvh8& bvh, const SahModel& sah, std::uint32_t face_count,
                   Stream stream, std::size_t max_triangles) {
  return compute(bvh, sah, face_count, stream, max_triangles);
}
double compute_epo(const DeviceCwbvh& bvh, const SahModel& sah, std::uint32_t face_count,
                   Stream stream, std::size_t max_triangles) {
  return compute(bvh, sah, face_count, stream, max_triangles);
}

}  // namespace treelet::cuda
