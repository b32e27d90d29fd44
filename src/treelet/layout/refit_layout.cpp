#include <treelet/layout/refit_layout.h>

#include <cstdint>
#include <type_traits>
#include <utility>

#include <treelet/core/parallel.h>
#include <treelet/core/stage.h>
#include <treelet/layout/layout_access.h>
#include <treelet/layout/refit_layout_steps.h>

namespace treelet {
namespace {

constexpr std::size_t kGrain = 1 << 10;  // nodes

PackedTriangle* items_of(Bvh2& bvh) { return bvh.triangles.data(); }
TriangleBlock* items_of(Bvh8& bvh) { return bvh.blocks.data(); }

/// What fitting some children adds to the result.
struct Sums {
  double cost = 0.0;  // in units of area
  std::size_t hidden = 0;

  friend Sums operator+(Sums a, Sums b) { return {a.cost + b.cost, a.hidden + b.hidden}; }
};

/// Fits ranges of nodes from the back, all at the same time, but for the nodes that wait for a box
/// from another range; then those, which are few in depth-first order: the ancestors of the nodes
/// that begin a range.
template <class Layout>
class Refit {
 public:
  Refit(Layout& bvh, const Mesh& mesh, const SahModel& sah)
      : bvh_(bvh), mesh_(mesh), sah_(sah), waits_(bvh.nodes.size()) {}

  RefitResult run() {
    if (bvh_.nodes.empty()) return {};
    Sums sums = parallel_reduce(
        bvh_.nodes.size(), kGrain, Sums{},
        [&](std::size_t begin, std::size_t end) { return fit_range(begin, end); },
        [](const Sums& a, const Sums& b) { return a + b; });
    for (std::size_t node = bvh_.nodes.size(); node-- > 0;) {
      if (waits_[node]) sums.cost += fit_internal(bvh_.nodes[node]);
    }
    bvh_.bounds = node_box(bvh_.nodes[0]);
    return {relative_cost(sums.cost), sums.hidden};
  }

 private:
  using Node = std::remove_reference_t<decltype(std::declval<Layout>().nodes[0])>;

  Sums fit_range(std::size_t begin, std::size_t end) {
    Sums sums;
    for (std::size_t i = end; i-- > begin;) {
      Node& node = bvh_.nodes[i];
      sums = sums + fit_leaves(node);
      waits_[i] = must_wait(node, end);
      if (!waits_[i]) sums.cost += fit_internal(node);
    }
    return sums;
  }

  /// Children lie behind their parents.
  bool must_wait(const Node& node, std::size_t end) const {
    for (int i = 0; i < kChildren<Node>; ++i) {
      if (!is_node_child(node, i)) continue;
      const std::uint32_t below = node_index(node, i);
      if (below >= end || waits_[below]) return true;
    }
    return false;
  }

  /// Returns the cost of the children.
  double fit_internal(Node& node) {
    double cost = 0.0;
    for (int i = 0; i < kChildren<Node>; ++i) {
      if (!is_node_child(node, i)) continue;
      const Aabb box = node_box(bvh_.nodes[node_index(node, i)]);
      set_child_box(node, i, box);
      cost += sah_.traversal_cost * half_area_double(box);
    }
    return cost;
  }

  Sums fit_leaves(Node& node) {
    const auto triangle_of = [&](std::uint32_t face) { return mesh_.triangle(face); };
    auto* const items = items_of(bvh_);
    Sums sums;
    for (int i = 0; i < kChildren<Node>; ++i) {
      if (!is_leaf_child(node, i)) continue;
      const PositionRange leaf = leaf_positions(node, i);
      const LeafFit fit = LeafRefit(items, leaf, triangle_of).run(child_box(node, i));
      set_child_box(node, i, fit.box);
      sums.cost +=
          double(sah_.intersection_cost) * count_triangles(items, leaf) * half_area_double(fit.box);
      sums.hidden += fit.hidden;
    }
    return sums;
  }

  /// As in layout/statistics.cpp: a single leaf has no node above it.
  double relative_cost(double cost) const {
    const double root_area = half_area_double(bvh_.bounds);
    const bool is_single_leaf = bvh_.nodes.size() == 1 && child_box(bvh_.nodes[0], 1).is_empty();
    if (!is_single_leaf) cost += sah_.traversal_cost * root_area;
    return root_area > 0.0 ? cost / root_area : 0.0;
  }

  Layout& bvh_;
  const Mesh& mesh_;
  const SahModel& sah_;
  Array<std::uint8_t> waits_;  // by node: for a box from a later range
};

}  // namespace

RefitResult refit(Bvh2& bvh, const Mesh& mesh, const SahModel& sah) {
  const Stage stage{"refit layout"};
  return Refit(bvh, mesh, sah).run();
}
RefitResult refit(Bvh8& bvh, const Mesh& mesh, const SahModel& sah) {
  const Stage stage{"refit layout"};
  return Refit(bvh, mesh, sah).run();
}

}  // namespace treelet
