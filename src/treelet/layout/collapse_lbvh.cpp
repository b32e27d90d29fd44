#include <treelet/layout/collapse_lbvh.h>

#include <algorithm>

#include <treelet/build/lbvh_emission.h>
#include <treelet/core/box_lanes.h>
#include <treelet/core/stage.h>
#include <treelet/layout/wide_collapse_fold.h>

namespace treelet {
namespace {

/// Nodes that leave nothing but their decisions.
class CollapsingNodes {
 public:
  struct Value {
    BoxLanes box;
    CollapsedSubtree subtree;
    std::uint32_t count;
  };

  CollapsingNodes(const References& references, const WideCollapseFold& fold,
                  Array<std::uint32_t>& faces)
      : items_(references.items.data()), fold_(fold), faces_(faces.data()) {}

  void set_leaf(Value& node, std::size_t key, std::uint32_t reference) const {
    faces_[key] = items_[reference].face;
    node.box = BoxLanes::load_box(items_[reference]);
    fold_.set_leaf(node.box.half_area(), reference, node.subtree);
    node.count = 1;
  }
  void join(Value& left, const Value& right, std::uint32_t left_slot) const {
    left.box = merge(left.box, right.box);
    left.count += right.count;
    fold_.join(left.subtree, right.subtree, left.box.half_area(), left.count, left_slot,
               left.subtree);
  }
  void prefetch(std::uint32_t reference) const { TREELET_PREFETCH(&items_[reference]); }

 private:
  const Reference* const items_;
  const WideCollapseFold& fold_;
  std::uint32_t* const faces_;
};

}  // namespace

WideCollapse collapse_lbvh(const References& references, const WideCostModel& model,
                           const SahModel& sah) {
  const MortonOrder order = sort_along_morton_curve(references);
  const Stage stage{"emit and collapse"};
  WideCollapse collapse{Array<CollapsedNode>(2 * references.size())};
  if (references.size() == 0) return collapse;
  const WideCollapseFold fold(model, sah, collapse);
  collapse.faces = Array<std::uint32_t>(references.size());
  const CollapsingNodes nodes(references, fold, collapse.faces);
  LbvhEmission emission(order, nodes);
  const auto root = emission.run();
  fold.finish(root.box.half_area(), root.subtree);
  collapse.large = emission.top_slots();
  std::sort(collapse.large.begin(), collapse.large.end());
  return collapse;
}

}  // namespace treelet
