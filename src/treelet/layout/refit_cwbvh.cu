#include <treelet/layout/device_refit_layout.h>

#include <treelet/layout/leaf_box_steps.h>
#include <treelet/layout/node_links.cuh>

// A grid lies over the whole of a node, so nodes are compressed when all exact boxes are known:
// first these are found from below, in the links, then each node by itself is written anew.

namespace treelet::cuda {
namespace {

constexpr unsigned kLanes = CwbvhNode::kChildren;

// How a leaf's box follows from that of its triangles; each is asked twice about a leaf.
struct TakeWhole {
  __device__ Aabb operator()(const Aabb& box, const CwbvhTriangle&) const { return box; }
  __device__ void forget(CwbvhTriangle&) const {}
};
struct KeepPieces {
  PieceBoxes pieces;

  __device__ Aabb operator()(const Aabb& box, const CwbvhTriangle& first) const {
    const double scale = power_of_two(pieces.scene->scale_exponent);
    const Aabb of_pieces = to_mesh_units(pieces.nodes[first.reserved1].box(), scale);
    return overlap(box, of_pieces);
  }
  __device__ void forget(CwbvhTriangle& first) const { first.reserved1 = 0; }
};

/// A thread a child.
__device__ std::uint32_t node_of_thread() {
  return blockIdx.x * (kRefitThreads / kLanes) + threadIdx.x / kLanes;
}

/// Of the children of one node.
__device__ Aabb merge_over_lanes(Aabb box) {
  for (unsigned distance = kLanes / 2; distance > 0; distance /= 2) {
    const auto other = [&](float x) { return __shfl_xor_sync(kFullWarp, x, int(distance)); };
    box = merge(box, {{other(box.lower.x), other(box.lower.y), other(box.lower.z)},
                      {other(box.upper.x), other(box.upper.y), other(box.upper.z)}});
  }
  return box;
}

template <class BoxRule>
class CwbvhRefit {
 public:
  __device__ CwbvhRefit(const DeviceCwbvh& bvh, BoxLink* links, const BoxRule& rule)
      : bvh_(bvh), links_(links), nodes_(bvh, links), rule_(rule) {}

  __device__ bool has_node(std::uint32_t node) const { return nodes_.has_node(node); }

  /// Moves the triangles of a leaf; empty for another child.
  __device__ Aabb fit_leaf(std::uint32_t node, int i, const DeviceMesh& mesh) const {
    if (!bvh_.nodes[node].is_leaf(i)) return Aabb::empty();
    const PositionRange leaf = leaf_positions(bvh_.nodes[node], i);
    const Aabb box = move_leaf(bvh_, leaf, mesh, child_box(bvh_.nodes[node], i));
    return with_positive_zeros(rule_(box, bvh_.items[leaf.begin]));
  }

  /// By one thread, with the box of all leaves of the node.
  __device__ void climb(std::uint32_t node, const Aabb& leaves) const {
    links_[node].box = leaves;
    while (nodes_.is_last(node)) {
      Aabb box = links_[node].box;
      for (int i = 0; i < CwbvhNode::kChildren; ++i) {
        if (bvh_.nodes[node].is_node(i)) box = merge(box, links_[bvh_.nodes[node].node(i)].box);
      }
      links_[node].box = box;
      if (node == 0) {
        bvh_.summary->bounds = box;
        return;
      }
      node = links_[node].parent;
    }
  }

  /// A thread a child, when all boxes are known; the first one writes the grid.
  __device__ void compress_child(std::uint32_t index, int i) const {
    CwbvhNode& node = bvh_.nodes[index];
    const CwbvhGrid grid(links_[index].box);
    if (i == 0) grid.write_to(node);
    Aabb box = Aabb::empty();
    if (node.is_leaf(i)) {
      box = leaf_box(leaf_positions(node, i));
    } else if (node.is_node(i)) {
      box = links_[node.node(i)].box;
    }
    CwbvhPlanes(grid, box).write_to(node, i);
  }

 private:
  /// As fit_leaf has left it: triangles that are hidden are where no box grows for them.
  __device__ Aabb leaf_box(PositionRange leaf) const {
    Aabb box = Aabb::empty();
    for (std::uint32_t i = leaf.begin; i < leaf.end; ++i) {
      box = merge(box, bounds(triangle_at(bvh_.items, i)));
    }
    CwbvhTriangle& first = bvh_.items[leaf.begin];
    box = with_positive_zeros(rule_(box, first));
    rule_.forget(first);
    return box;
  }

  const DeviceCwbvh& bvh_;
  BoxLink* links_;
  const NodeLinks<DeviceCwbvh> nodes_;
  const BoxRule& rule_;
};

template <class BoxRule>
__global__ void fit_boxes_kernel(DeviceCwbvh bvh, DeviceMesh mesh, BoxLink* links, BoxRule rule) {
  const CwbvhRefit<BoxRule> refit(bvh, links, rule);
  const std::uint32_t node = node_of_thread();
  const int child = int(threadIdx.x % kLanes);
  Aabb leaves = Aabb::empty();
  if (refit.has_node(node)) leaves = refit.fit_leaf(node, child, mesh);
  leaves = merge_over_lanes(leaves);
  if (refit.has_node(node) && child == 0) refit.climb(node, leaves);
}

template <class BoxRule>
__global__ void compress_kernel(DeviceCwbvh bvh, BoxLink* links, BoxRule rule) {
  const CwbvhRefit<BoxRule> refit(bvh, links, rule);
  const std::uint32_t node = node_of_thread();
  if (refit.has_node(node)) refit.compress_child(node, int(threadIdx.x % kLanes));
}

template <class BoxRule>
void enqueue(const DeviceCwbvh& bvh, const DeviceMesh& mesh, const BoxRule& rule, BoxLink* links,
             Stream stream) {
  const Grid children = thread_each(bvh.node_capacity * std::size_t(kLanes), kRefitThreads);
  launch(stream, thread_each(bvh.node_capacity, kRefitThreads), link_kernel<DeviceCwbvh>, bvh,
         links);
  launch(stream, children, fit_boxes_kernel<BoxRule>, bvh, mesh, links, rule);
  launch(stream, children, compress_kernel<BoxRule>, bvh, links, rule);
}

}  // namespace

void refit(const DeviceCwbvh& bvh, const DeviceMesh& mesh, BoxLink* links, Stream stream) {
  enqueue(bvh, mesh, TakeWhole{}, links, stream);
}

void fit_pieces(const DeviceCwbvh& bvh, const DeviceMesh& mesh, const PieceBoxes& pieces,
                BoxLink* links, Stream stream) {
  enqueue(bvh, mesh, KeepPieces{pieces}, links, stream);
}

}  // namespace treelet::cuda
