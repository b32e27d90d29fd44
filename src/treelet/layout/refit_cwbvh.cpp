#include <treelet/layout/refit_layout.h>

#include <cstdint>

#include <treelet/core/array.h>
#include <treelet/core/parallel.h>
#include <treelet/core/stage.h>
#include <treelet/layout/cwbvh_steps.h>
#include <treelet/layout/refit_layout_steps.h>
#include <treelet/layout/statistics_steps.h>

// A grid lies over the whole of a node, so nodes are compressed when all exact boxes are known:
// first these are found from below, then each node by itself is written anew.

namespace treelet {
namespace {

constexpr std::size_t kGrain = 1 << 10;  // nodes

class CwbvhRefit {
 public:
  CwbvhRefit(Cwbvh& bvh, const Mesh& mesh, const SahModel& sah)
      : bvh_(bvh), mesh_(mesh), sah_(sah), boxes_(bvh.nodes.size()), waits_(bvh.nodes.size()) {}

  RefitResult run() {
    if (bvh_.nodes.empty()) return {};
    const std::size_t hidden = parallel_reduce(
        bvh_.nodes.size(), kGrain, std::size_t{0},
        [&](std::size_t begin, std::size_t end) { return fit_range(begin, end); },
        [](std::size_t a, std::size_t b) { return a + b; });
    for (std::size_t node = bvh_.nodes.size(); node-- > 0;) {
      if (waits_[node]) merge_children(node);
    }
    bvh_.bounds = boxes_[0];
    const double cost = parallel_reduce(
        bvh_.nodes.size(), kGrain, 0.0,
        [&](std::size_t begin, std::size_t end) { return compress_range(begin, end); },
        [](double a, double b) { return a + b; });
    return {relative_cost(cost, bvh_.nodes[0], sah_), hidden};
  }

 private:
  /// From the back. What waits for a box from another range is left for later: few nodes, the
  /// ancestors of those that begin a range, and the ancestors' siblings.
  std::size_t fit_range(std::size_t begin, std::size_t end) {
    std::size_t hidden = 0;
    for (std::size_t node = end; node-- > begin;) {
      hidden += fit_leaves(node);
      waits_[node] = must_wait(bvh_.nodes[node], end);
      if (!waits_[node]) merge_children(node);
    }
    return hidden;
  }

  std::size_t fit_leaves(std::size_t index) {
    const auto triangle_of = [&](std::uint32_t face) { return mesh_.triangle(face); };
    const CwbvhNode& node = bvh_.nodes[index];
    Aabb box = Aabb::empty();
    std::size_t hidden = 0;
    for (int i = 0; i < CwbvhNode::kChildren; ++i) {
      if (!node.is_leaf(i)) continue;
      const LeafFit fit = LeafRefit(bvh_.triangles.data(), leaf_positions(node, i), triangle_of)
                              .run(decode_box(node, i));
      box = merge(box, with_positive_zeros(fit.box));
      hidden += fit.hidden;
    }
    boxes_[index] = box;
    return hidden;
  }

  /// Children lie behind their parents.
  bool must_wait(const CwbvhNode& node, std::size_t end) const {
    for (int i = 0; i < CwbvhNode::kChildren; ++i) {
      if (node.is_node(i) && (node.node(i) >= end || waits_[node.node(i)])) return true;
    }
    return false;
  }

  void merge_children(std::size_t index) {
    const CwbvhNode& node = bvh_.nodes[index];
    for (int i = 0; i < CwbvhNode::kChildren; ++i) {
      if (node.is_node(i)) boxes_[index] = merge(boxes_[index], boxes_[node.node(i)]);
    }
  }

  /// Returns the cost of the children.
  double compress_range(std::size_t begin, std::size_t end) {
    for (std::size_t index = begin; index < end; ++index) {
      CwbvhNode& node = bvh_.nodes[index];
      const CwbvhGrid grid(boxes_[index]);
      grid.write_to(node);
      for (int i = 0; i < CwbvhNode::kChildren; ++i) {
        CwbvhPlanes(grid, exact_box(node, i)).write_to(node, i);
      }
    }
    return sum_child_costs(bvh_.nodes.data(), bvh_.triangles.data(), std::uint32_t(begin),
                           std::uint32_t(end), sah_, [](std::uint32_t) {});
  }

  /// Of a leaf, as it has been fitted: hidden triangles are where no box grows for them.
  Aabb exact_box(const CwbvhNode& node, int i) const {
    if (node.is_node(i)) return boxes_[node.node(i)];
    Aabb box = Aabb::empty();
    if (node.is_none(i)) return box;
    const PositionRange leaf = leaf_positions(node, i);
    for (std::uint32_t k = leaf.begin; k < leaf.end; ++k) {
      box = merge(box, bounds(bvh_.triangles[k].triangle()));
    }
    return with_positive_zeros(box);
  }

  Cwbvh& bvh_;
  const Mesh& mesh_;
  const SahModel& sah_;
  Array<Aabb> boxes_;          // by node, exact: of its leaves, then of all its children
  Array<std::uint8_t> waits_;  // by node: for a box from a later range
};

}  // namespace

RefitResult refit(Cwbvh& bvh, const Mesh& mesh, const SahModel& sah) {
  const Stage stage{"refit layout"};
  return CwbvhRefit(bvh, mesh, sah).run();
}

}  // namespace treelet
