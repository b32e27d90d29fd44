#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <treelet/layout/device_layout.h>
#include <treelet/layout/layout_access.h>
#include <treelet/query/nearest.h>
#include <treelet/query/point_box_steps.h>
#include <treelet/query/point_filter_steps.h>
#include <treelet/query/point_triangle_steps.h>
#include <treelet/traverse/device_stack.h>
#include <treelet/core/launch.cuh>

namespace treelet::cuda {

/// All children but one wait a level while that is searched, whatever the layout.
template <class Layout>
constexpr std::size_t nearest_stack_entries(std::size_t depth) {
  return depth * std::size_t(kChildren<typename Layout::Node> - 1) + 1;
}

/// One thread's search for the triangle nearest to a point, as ScalarNearestSearcher
/// (query/nearest_search.h) goes about it. Which boxes are looked into may differ from the host's
/// order; what is found does not depend on that.
template <class Layout>
class DeviceNearestSearch {
 public:
  __device__ DeviceNearestSearch(const Layout& bvh, WaitingChild* stack)
      : bvh_(bvh), stack_(stack) {}

  /// The tree must have nodes, the point be finite.
  __device__ Nearest find(const NearestQuery& query) {
    const Aabb& scene = bvh_.summary->bounds;
    point_ = query.point;
    placed_ = point_steps::place_in_scene(&point_.x, &scene.lower.x, &scene.upper.x);
    nearest_ = {query.largest, Nearest::kNone, 0};
    set_limit();
    visit_node(bvh_.nodes[0]);
    while (size_ > 0) {
      const WaitingChild next = stack_[--size_];
      if (next.enter <= limit_) visit_node(bvh_.nodes[next.node]);
    }
    return nearest_;
  }

 private:
  using Node = typename Layout::Node;

  /// Children that may hold something nearer, the nearest first.
  struct Children {
    int order[kChildren<Node>];
    float excess[kChildren<Node>];
    int count = 0;

    __device__ void insert(int child, float e) {
      int place = count++;
      for (; place > 0 && e < excess[place - 1]; --place) {
        excess[place] = excess[place - 1];
        order[place] = order[place - 1];
      }
      excess[place] = e;
      order[place] = child;
    }
  };

  /// Tests leaves, nearer ones first, and queues nodes, the nearest on top.
  __device__ void visit_node(const Node& node) {
    const Children children = near_children(node);
    for (int k = 0; k < children.count; ++k) {
      const int child = children.order[k];
      if (!is_leaf_child(node, child) || children.excess[k] > limit_) continue;
      visit_leaf(leaf_positions(node, child));
    }
    for (int k = children.count - 1; k >= 0; --k) {
      const int child = children.order[k];
      if (is_leaf_child(node, child) || children.excess[k] > limit_) continue;
      stack_[size_++] = {node_index(node, child), children.excess[k]};
    }
  }

  __device__ Children near_children(const Node& node) const {
    Children children;
    for (int i = 0; i < kChildren<Node>; ++i) {
      if (!is_leaf_child(node, i) && !is_node_child(node, i)) continue;
      const Aabb box = child_box(node, i);
      const float e = point_steps::excess(placed_, &box.lower.x, &box.upper.x);
      if (!(e > limit_)) children.insert(i, e);
    }
    return children;
  }

  __device__ void visit_leaf(PositionRange leaf) {
    const typename Layout::Item* const items = bvh_.items;
    for (std::uint32_t i = leaf.begin; i < leaf.end; ++i) {
      const std::uint32_t face = face_at(items, i);
      if (face == TriangleBlock::kNoFace) continue;
      const Triangle triangle = triangle_at(items, i);
      if (may_be_nearer(triangle)) test_triangle(triangle, face, i);
    }
  }

  __device__ bool may_be_nearer(const Triangle& triangle) const {
    const Aabb box = bounds(triangle);
    if (point_steps::excess(placed_, &box.lower.x, &box.upper.x) > limit_) return false;
    const point_steps::TriangleFilter<point_steps::OneFloat> filter(
        in_floats(point_), placed_.scale, in_floats(triangle.p0), in_floats(triangle.p1),
        in_floats(triangle.p2));
    return !filter.is_beyond(filter_limit_);
  }

  __device__ static point_steps::Vector<float> in_floats(Vec3 p) { return {p.x, p.y, p.z}; }

  __device__ void test_triangle(const Triangle& triangle, std::uint32_t face,
                                std::uint32_t position) {
    const double square = point_steps::view_from(point_, triangle).squared_distance();
    const double best = nearest_.squared_distance;
    if (!(square < best || (square == best && face < nearest_.face))) return;
    if (point_steps::is_hidden(triangle)) return;
    nearest_ = {square, face, position};
    set_limit();
  }

  __device__ void set_limit() {
    limit_ = point_steps::excess_limit(placed_, nearest_.squared_distance);
    filter_limit_ = point_steps::filter_limit(placed_, nearest_.squared_distance);
  }

  const Layout& bvh_;
  WaitingChild* const stack_;
  std::uint32_t size_ = 0;
  Vec3 point_{};
  PointInScene placed_{};
  Nearest nearest_{};
  float limit_ = 0.0f, filter_limit_ = 0.0f;
};

}  // namespace treelet::cuda
