#pragma once

#include <cstdint>

#include <treelet/layout/device_layout.h>
#include <treelet/layout/device_refit_layout.h>
#include <treelet/layout/layout_access.h>
#include <treelet/layout/refit_layout_steps.h>
#include <treelet/core/launch.cuh>

namespace treelet::cuda {

constexpr unsigned kRefitThreads = 256;

/// The way up from the nodes of a layout: the last of a node's children to have its box goes on to
/// the parent [Karras2012 s4].
template <class Layout>
class NodeLinks {
 public:
  using Node = typename Layout::Node;

  __device__ NodeLinks(const Layout& bvh, LinkOf<Layout>* links) : bvh_(bvh), links_(links) {}

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

  /// Whether all children have their boxes; asked once for the leaves, once for each child that is
  /// a node.
  __device__ bool is_last(std::uint32_t node) const {
    std::uint32_t expected = 1;
    for (int i = 0; i < kChildren<Node>; ++i) expected += is_node_child(bvh_.nodes[node], i);
    const std::uint32_t before = __nv_atomic_fetch_add(
        &links_[node].arrived, 1u, __NV_ATOMIC_ACQ_REL, __NV_THREAD_SCOPE_DEVICE);
    return before + 1 == expected;
  }

 private:
  const Layout& bvh_;
  LinkOf<Layout>* links_;
};

template <class Layout>
__global__ void link_kernel(Layout bvh, LinkOf<Layout>* links) {
  const NodeLinks<Layout> nodes(bvh, links);
  if (nodes.has_node(thread_index())) nodes.link_children(thread_index());
}

/// Moves the triangles of a leaf; returns its box. `last_box` as of LeafRefit.
template <class Layout>
__device__ Aabb move_leaf(const Layout& bvh, PositionRange positions, const DeviceMesh& mesh,
                          const Aabb& last_box) {
  const auto triangle_of = [&](std::uint32_t face) {
    const Face corners = mesh.faces[face];
    return Triangle{mesh.vertices[corners[0]], mesh.vertices[corners[1]],
                    mesh.vertices[corners[2]]};
  };
  const LeafRefit<typename Layout::Item, decltype(triangle_of)> leaf(bvh.items, positions,
                                                                     triangle_of);
  const LeafFit fit = leaf.run(last_box);
  if (fit.hidden > 0) atomicAdd(&bvh.summary->hidden, fit.hidden);
  return fit.box;
}

}  // namespace treelet::cuda
