#include <treelet/layout/device_refit_layout.h>

#include <treelet/layout/leaf_box_steps.h>
#include <treelet/layout/refit_layout_steps.h>
#include <treelet/core/launch.cuh>

namespace treelet::cuda {
namespace {

constexpr unsigned kThreads = 256;

// How a leaf's box follows from that of its triangles and the one it had.
struct TakeWhole {
  __device__ Aabb operator()(const Aabb& box, const Aabb&) const { return box; }
};
struct KeepWithin {
  __device__ Aabb operator()(const Aabb& box, const Aabb& last) const { return overlap(box, last); }
};

/// Fits nodes from below: the last of a node's children to have its box goes on to the parent
/// [Karras2012 s4].
template <class Layout>
class Refit {
 public:
  using Node = typename Layout::Node;
  using Item = typename Layout::Item;

  __device__ Refit(const Layout& bvh, NodeLink* links) : bvh_(bvh), links_(links) {}

  __device__ bool has_node(std::uint32_t node) const { return node < bvh_.summary->size.nodes; }

  __device__ void link_children(std::uint32_t node) const {
    links_[node].arrived = 0;
    if (node == 0) bvh_.summary->hidden = 0;
    for (int i = 0; i < kChildren<Node>; ++i) {
      if (is_node_child(bvh_.nodes[node], i)) {
        links_[node_index(bvh_.nodes[node], i)].parent = node;
      }
    }
  }

  template <class BoxRule>
  __device__ void fit_leaf(std::uint32_t node, int i, const DeviceMesh& mesh, BoxRule rule) const {
    if (!is_leaf_child(bvh_.nodes[node], i)) return;
    const auto triangle_of = [&](std::uint32_t face) {
      const Face corners = mesh.faces[face];
      return Triangle{mesh.vertices[corners[0]], mesh.vertices[corners[1]],
                      mesh.vertices[corners[2]]};
    };
    const LeafRefit<Item, decltype(triangle_of)> leaf(
        bvh_.items, leaf_positions(bvh_.nodes[node], i), triangle_of);
    const Aabb last_box = child_box(bvh_.nodes[node], i);
    const LeafFit fit = leaf.run(last_box);
    set_child_box(bvh_.nodes[node], i, rule(fit.box, last_box));
    if (fit.hidden > 0) atomicAdd(&bvh_.summary->hidden, fit.hidden);
  }

  /// By one thread, after all leaves of the node.
  __device__ void climb(std::uint32_t node) const {
    while (is_last(node)) {
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
  __device__ bool is_last(std::uint32_t node) const {
    std::uint32_t expected = 1;
    for (int i = 0; i < kChildren<Node>; ++i) expected += is_node_child(bvh_.nodes[node], i);
    const std::uint32_t before = __nv_atomic_fetch_add(
        &links_[node].arrived, 1u, __NV_ATOMIC_ACQ_REL, __NV_THREAD_SCOPE_DEVICE);
    return before + 1 == expected;
  }

  __device__ static int find_child(const Node& parent, std::uint32_t node) {
    int i = 0;
    while (!is_node_child(parent, i) || node_index(parent, i) != node) ++i;
    return i;
  }

  const Layout& bvh_;
  NodeLink* links_;
};

template <class Layout>
__global__ void link_kernel(Layout bvh, NodeLink* links) {
  const Refit<Layout> refit(bvh, links);
  if (refit.has_node(thread_index())) refit.link_children(thread_index());
}

/// A thread a child.
template <class BoxRule, class Layout>
__global__ void fit_kernel(Layout bvh, DeviceMesh mesh, NodeLink* links) {
  constexpr unsigned kLanes = kChildren<typename Layout::Node>;
  const Refit<Layout> refit(bvh, links);
  const std::uint32_t node = blockIdx.x * (kThreads / kLanes) + threadIdx.x / kLanes;
  const unsigned child = threadIdx.x % kLanes;
  if (refit.has_node(node)) refit.fit_leaf(node, int(child), mesh, BoxRule{});
  __syncwarp();
  if (refit.has_node(node) && child == 0) refit.climb(node);
}

template <class BoxRule, class Layout>
void enqueue(const Layout& bvh, const DeviceMesh& mesh, NodeLink* links, Stream stream) {
  constexpr std::size_t kLanes = kChildren<typename Layout::Node>;
  launch(stream, thread_each(bvh.node_capacity, kThreads), link_kernel<Layout>, bvh, links);
  launch(stream, thread_each(bvh.node_capacity * kLanes, kThreads), fit_kernel<BoxRule, Layout>,
         bvh, mesh, links);
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
