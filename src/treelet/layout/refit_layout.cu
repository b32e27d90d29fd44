#include <treelet/layout/device_refit_layout.h>

#include <treelet/layout/leaf_box_steps.h>
#include <treelet/layout/node_links.cuh>

namespace treelet::cuda {
namespace {

// How a leaf's box follows from that of its triangles and the one it had.
struct TakeWhole {
  __device__ Aabb operator()(const Aabb& box, const Aabb&) const { return box; }
};
struct KeepWithin {
  __device__ Aabb operator()(const Aabb& box, const Aabb& last) const { return overlap(box, last); }
};

/// Fits nodes from below.
template <class Layout>
class Refit {
 public:
  using Node = typename Layout::Node;

  __device__ Refit(const Layout& bvh, NodeLink* links)
      : bvh_(bvh), links_(links), nodes_(bvh, links) {}

  __device__ bool has_node(std::uint32_t node) const { return nodes_.has_node(node); }

  template <class BoxRule>
  __device__ void fit_leaf(std::uint32_t node, int i, const DeviceMesh& mesh, BoxRule rule) const {
    if (!is_leaf_child(bvh_.nodes[node], i)) return;
    const Aabb last_box = child_box(bvh_.nodes[node], i);
    const Aabb box = move_leaf(bvh_, leaf_positions(bvh_.nodes[node], i), mesh, last_box);
    set_child_box(bvh_.nodes[node], i, rule(box, last_box));
  }

  /// By one thread, after all leaves of the node.
  __device__ void climb(std::uint32_t node) const {
    while (nodes_.is_last(node)) {
      const Aabb box = node_box(bvh_.nodes[node]);
      if (node == 0) {
        bvh_.summary->bounds = box;
        return;
      }
      const std::uint32_t parent = links_[node].parent;
      set_child_box(bvh_.nodes[parent], find_child(bvh_.nodes[parent], node), box);
      node = parent;
    }
  }

 private:
  __device__ static int find_child(const Node& parent, std::uint32_t node) {
    int i = 0;
    while (!is_node_child(parent, i) || node_index(parent, i) != node) ++i;
    return i;
  }

  const Layout& bvh_;
  NodeLink* links_;
  const NodeLinks<Layout> nodes_;
};

/// A thread a child.
template <class BoxRule, class Layout>
__global__ void fit_kernel(Layout bvh, DeviceMesh mesh, NodeLink* links) {
  constexpr unsigned kLanes = kChildren<typename Layout::Node>;
  const Refit<Layout> refit(bvh, links);
  const std::uint32_t node = blockIdx.x * (kRefitThreads / kLanes) + threadIdx.x / kLanes;
  const unsigned child = threadIdx.x % kLanes;
  if (refit.has_node(node)) refit.fit_leaf(node, int(child), mesh, BoxRule{});
  __syncwarp();
  if (refit.has_node(node) && child == 0) refit.climb(node);
}

template <class BoxRule, class Layout>
void enqueue(const Layout& bvh, const DeviceMesh& mesh, NodeLink* links, Stream stream) {
  constexpr std::size_t kLanes = kChildren<typename Layout::Node>;
  launch(stream, thread_each(bvh.node_capacity, kRefitThreads), link_kernel<Layout>, bvh, links);
  launch(stream, thread_each(bvh.node_capacity * kLanes, kRefitThreads),
         fit_kernel<BoxRule, Layout>, bvh, mesh, links);
}

}  // namespace

void refit(const DeviceBvh2& bvh, const DeviceMesh& mesh, NodeLink* links, Stream stream) {
  enqueue<TakeWhole>(bvh, mesh, links, stream);
}
void refit(const DeviceBvh8& bvh, const DeviceMesh& mesh, NodeLink* links, Stream stream) {
  enqueue<TakeWhole>(bvh, mesh, links, stream);
}

void fit_pieces(const DeviceBvh2& bvh, const DeviceMesh& mesh, NodeLink* links, Stream stream) {
  enqueue<KeepWithin>(bvh, mesh, links, stream);
}
void fit_pieces(const DeviceBvh8& bvh, const DeviceMesh& mesh, NodeLink* links, Stream stream) {
  enqueue<KeepWithin>(bvh, mesh, links, stream);
}

}  // namespace treelet::cuda
