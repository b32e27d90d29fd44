#pragma once

#include <cstddef>
#include <span>

#include <treelet/layout/layout_access.h>
#include <treelet/query/nearest.h>
#include <treelet/query/nearest_bvh8.h>
#include <treelet/query/point_box_steps.h>
#include <treelet/query/point_filter_steps.h>
#include <treelet/query/point_triangle_steps.h>
#include <treelet/traverse/traversal_stack.h>
#include <treelet/traverse/traverse_bvh2.h>
#include <treelet/traverse/traverse_bvh8.h>
#include <treelet/traverse/traverse_cwbvh.h>

namespace treelet {

/// Finds the triangles nearest to points, with a stack of its own: one a thread. Points must be
/// finite. Neighbours that come one after the other are found sooner.
template <class Layout>
class NearestSearcher;

/// Of a layout that is searched child by child. What Bvh8's kernels are tested against.
template <class Layout>
class ScalarNearestSearcher {
 public:
  explicit ScalarNearestSearcher(const Layout& bvh) : bvh_(bvh), stack_(stack_capacity(bvh)) {}

  void run(std::span<const NearestQuery> queries, Nearest* answers) {
    for (const NearestQuery& query : queries) *answers++ = find(query);
  }

 private:
  using Entry = TraversalStack::Entry;
  using Node = std::decay_t<decltype(std::declval<const Layout&>().nodes[0])>;

  Nearest find(const NearestQuery& query) {
    point_ = query.point;
    placed_ = point_steps::place_in_scene(&point_.x, &bvh_.bounds.lower.x, &bvh_.bounds.upper.x);
    nearest_ = {query.largest, Nearest::kNone, 0};
    if (bvh_.nodes.empty()) return nearest_;
    set_limit();
    if (last_ < bvh_.triangles.size()) test_triangle(last_);
    size_ = 0;
    visit_node(bvh_.nodes[0]);
    while (size_ > 0) {
      const Entry entry = stack_.entries()[--size_];
      if (entry.enter <= limit_) visit_node(bvh_.nodes[entry.node]);
    }
    if (!nearest_.is_none()) last_ = nearest_.position;
    return nearest_;
  }

  /// Tests leaves, nearer ones first, and queues nodes, the nearest on top.
  void visit_node(const Node& node) {
    int order[kChildren<Node>];
    float excess[kChildren<Node>];
    const int count = sort_children(node, order, excess);
    for (int k = 0; k < count; ++k) {
      if (is_leaf_child(node, order[k]) && excess[k] <= limit_) {
        visit_leaf(leaf_positions(node, order[k]));
      }
    }
    for (int k = count - 1; k >= 0; --k) {
      if (is_leaf_child(node, order[k]) || excess[k] > limit_) continue;
      stack_.entries()[size_++] = {node_index(node, order[k]), excess[k]};
    }
  }

  int sort_children(const Node& node, int* order, float* excess) const {
    int count = 0;
    for (int i = 0; i < kChildren<Node>; ++i) {
      if (!is_leaf_child(node, i) && !is_node_child(node, i)) continue;
      const Aabb box = child_box(node, i);
      const float e = point_steps::excess(placed_, &box.lower.x, &box.upper.x);
      if (e > limit_) continue;
      int place = count++;
      for (; place > 0 && e < excess[place - 1]; --place) {
        excess[place] = excess[place - 1];
        order[place] = order[place - 1];
      }
      excess[place] = e;
      order[place] = i;
    }
    return count;
  }

  void visit_leaf(PositionRange leaf) {
    for (std::uint32_t i = leaf.begin; i < leaf.end; ++i) {
      if (may_be_nearer(bvh_.triangles[i].triangle())) test_triangle(i);
    }
  }

  bool may_be_nearer(const Triangle& triangle) const {
    const Aabb box = bounds(triangle);
    if (point_steps::excess(placed_, &box.lower.x, &box.upper.x) > limit_) return false;
    const auto vector = [](Vec3 p) { return point_steps::Vector<float>{p.x, p.y, p.z}; };
    return !point_steps::TriangleFilter<point_steps::OneFloat>(
                vector(point_), placed_.scale, vector(triangle.p0), vector(triangle.p1),
                vector(triangle.p2))
                .is_beyond(filter_limit_);
  }

  void test_triangle(std::uint32_t position) {
    const Triangle triangle = bvh_.triangles[position].triangle();
    const std::uint32_t face = bvh_.triangles[position].face;
    const double square = point_steps::view_from(point_, triangle).squared_distance();
    const double best = nearest_.squared_distance;
    if (!(square < best || (square == best && face < nearest_.face))) return;
    if (point_steps::is_hidden(triangle)) return;
    nearest_ = {square, face, position};
    set_limit();
  }

  void set_limit() {
    limit_ = point_steps::excess_limit(placed_, nearest_.squared_distance);
    filter_limit_ = point_steps::filter_limit(placed_, nearest_.squared_distance);
  }

  const Layout& bvh_;
  TraversalStack stack_;
  std::uint32_t size_ = 0;
  std::uint32_t last_ = 0;  ///< position of the triangle found last
  Vec3 point_{};
  PointInScene placed_{};
  Nearest nearest_{};
  float limit_ = 0.0f, filter_limit_ = 0.0f;
};

template <>
class NearestSearcher<Bvh2> : public ScalarNearestSearcher<Bvh2> {
 public:
  using ScalarNearestSearcher::ScalarNearestSearcher;
};

template <>
class NearestSearcher<Cwbvh> : public ScalarNearestSearcher<Cwbvh> {
 public:
  using ScalarNearestSearcher::ScalarNearestSearcher;
};

template <>
class NearestSearcher<Bvh8> {
 public:
  explicit NearestSearcher(const Bvh8& bvh, Isa isa = best_isa())
      : bvh_(bvh), stacks_(bvh, 1), search_(bvh8_nearest_search(isa)) {}

  void run(std::span<const NearestQuery> queries, Nearest* answers) {
    if (bvh_.nodes != nullptr) {
      return search_(bvh_, queries.data(), queries.size(), answers, stacks_.view());
    }
    std::fill_n(answers, queries.size(), Nearest{});
  }

 private:
  const Bvh8View bvh_;
  WaveStacks stacks_;
  const Bvh8NearestSearch search_;
};

}  // namespace treelet
