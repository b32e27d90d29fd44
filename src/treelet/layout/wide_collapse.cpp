#include <treelet/layout/wide_collapse.h>

#include <algorithm>

#include <treelet/core/box_lanes.h>
#include <treelet/core/stage.h>
#include <treelet/layout/face_counts.h>
#include <treelet/layout/wide_collapse_fold.h>
#include <treelet/layout/wide_collapse_steps.h>
#include <treelet/tree/bottom_up.h>

namespace treelet {

WideCollapse collapse_wide(const BinaryTree& tree, const References& references,
                           const WideCostModel& model, const SahModel& sah) {
  WideCollapse collapse{Array<CollapsedNode>(tree.nodes.size())};
  if (tree.empty()) return collapse;
  const FaceCounts faces(tree, references);
  const Stage stage{"collapse to 8-wide"};
  const WideCollapseFold fold(model, sah, collapse);
  const auto area_of = [&](std::uint32_t slot) {
    return BoxLanes::load_box(tree.nodes[slot]).half_area();
  };
  const auto leaf = [&](std::uint32_t slot, CollapsedSubtree& value) {
    fold.set_leaf(area_of(slot), tree.nodes[slot].index, value);
  };
  const auto join = [&](std::uint32_t slot, const CollapsedSubtree& left,
                        const CollapsedSubtree& right, CollapsedSubtree& node) {
    fold.join(left, right, area_of(slot), faces[slot], tree.nodes[slot].left(), node);
  };
  fold.finish(area_of(kRoot), fold_bottom_up<CollapsedSubtree>(tree, leaf, join));
  collapse.large = cut_tree(tree).top;
  std::sort(collapse.large.begin(), collapse.large.end());
  return collapse;
}

WideChildren list_wide_children(const WideCollapse& collapse, std::uint32_t slot) {
  const auto look_up = [&](std::uint32_t below) {
    const CollapsedNode& entry = collapse.by_slot[below];
    return WideSubtree{entry.decision, entry.index};
  };
  const WideSubtree root = look_up(slot);
  if (root.decision.is_leaf) return {{slot}, 1};
  return spread_over_children(root, look_up);
}

}  // namespace treelet
