#include <treelet/layout/wide_collapse.h>

#include <treelet/core/stage.h>
#include <treelet/layout/face_counts.h>
#include <treelet/layout/wide_collapse_lanes.h>
#include <treelet/layout/wide_collapse_steps.h>
#include <treelet/tree/bottom_up.h>

namespace treelet {

namespace {

/// What the two cost models make of a subtree.
struct SubtreeCosts {
  WideCosts wide;
  float sah;
};

}  // namespace

WideCollapse collapse_wide(const BinaryTree& tree, const References& references,
                           const WideCostModel& model, const SahModel& sah) {
  WideCollapse collapse{Array<WideDecision>(tree.reference_count())};
  if (tree.empty()) return collapse;
  const FaceCounts faces(tree, references);
  const Stage stage{"collapse to 8-wide"};
  const auto area_of = [&](std::uint32_t slot) { return half_area(tree.nodes[slot].box()); };
  const auto leaf = [&](std::uint32_t slot) -> SubtreeCosts {
    const float area = area_of(slot);
    return {WideCosts(wide_leaf_cost(area, 1, model)), sah.leaf_cost(area, 1)};
  };
  const auto join = [&](std::uint32_t slot, const SubtreeCosts& left, const SubtreeCosts& right) {
    SubtreeCosts costs;
    const float area = area_of(slot);
    const std::uint32_t triangles = faces[slot];
    collapse.by_pair[tree.nodes[slot].left() / 2] =
        choose_side_by_side(area, triangles, left.wide, right.wide, model, costs.wide);
    costs.sah = sah.subtree_cost(area, left.sah + right.sah, triangles);
    return costs;
  };
  const SubtreeCosts root = fold_bottom_up<SubtreeCosts>(tree, leaf, join);
  collapse.root_cost = root.wide[1];
  const double root_area = area_of(kRoot);
  collapse.sah = root_area > 0.0 ? root.sah / root_area : 0.0;
  return collapse;
}

WideChildren list_wide_children(const BinaryTree& tree, const WideCollapse& collapse,
                                std::uint32_t slot) {
  const auto look_up = [&](std::uint32_t below) {
    const BinaryNode& node = tree.nodes[below];
    return WideSubtree{collapse.decision(node), node.left()};
  };
  const WideSubtree root = look_up(slot);
  if (root.decision.is_leaf) return {{slot}, 1};
  return spread_over_children(root, look_up);
}

}  // namespace treelet
