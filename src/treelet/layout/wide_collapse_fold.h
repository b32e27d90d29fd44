#pragma once

#include <cstdint>
#include <vector>

#include <treelet/layout/wide_collapse.h>
#include <treelet/layout/wide_collapse_lanes.h>
#include <treelet/layout/wide_collapse_steps.h>
#include <treelet/tree/sah.h>

namespace treelet {

/// What the collapse knows of a subtree on the way up: its node, which is written with its
/// parent's, and what two cost models make of it. It is set in its place and never copied whole:
/// see WideCosts::set_leaf.
struct CollapsedSubtree {
  WideCosts wide;
  WideDecision decision;
  float sah;
  std::uint32_t index;  // not beside the decision, or a compiler would read both in one load

  CollapsedNode node() const { return {decision, index}; }
};

/// One step of the wide collapse a node, children before parents.
class WideCollapseFold {
 public:
  WideCollapseFold(const WideCostModel& model, const SahModel& sah, WideCollapse& collapse)
      : model_(model), sah_(sah), collapse_(collapse), blocks_(model.leaf_limit + 1) {
    for (std::uint32_t count = 0; count < blocks_.size(); ++count) {
      blocks_[count] = float(blocks_for(count, model.block_size));
    }
  }

  void set_leaf(float half_area, std::uint32_t reference, CollapsedSubtree& leaf) const {
    leaf.wide.set_leaf(leaf_cost(half_area, 1));
    leaf.decision = WideDecision::leaf();
    leaf.sah = sah_.leaf_cost(half_area, 1);
    leaf.index = reference;
  }

  /// Sets the value of a node of so many triangles, if need be over the left child's; the children
  /// lie at left_slot and the next.
  void join(const CollapsedSubtree& left, const CollapsedSubtree& right, float half_area,
            std::uint32_t triangles, std::uint32_t left_slot, CollapsedSubtree& node) const {
    collapse_.by_slot[left_slot] = left.node();
    collapse_.by_slot[left_slot + 1] = right.node();
    node.sah = sah_.subtree_cost(half_area, left.sah + right.sah, triangles);
    node.decision = choose_(leaf_cost(half_area, triangles), model_.node_cost * half_area,
                            left.wide, right.wide, node.wide);
    node.index = left_slot;
  }

  void finish(float half_area, const CollapsedSubtree& root) const {
    collapse_.by_slot[kRoot] = root.node();
    collapse_.by_slot[kRoot + 1] = {};  // of no node
    collapse_.root_cost = root.wide[1];
    collapse_.sah = half_area > 0.0f ? double(root.sah) / half_area : 0.0;
  }

 private:
  /// wide_leaf_cost without its division.
  float leaf_cost(float half_area, std::uint32_t triangles) const {
    if (triangles >= blocks_.size()) return WideCosts::kInfinity;
    return model_.block_cost * half_area * blocks_[triangles];
  }

  const WideCostModel& model_;
  const SahModel& sah_;
  WideCollapse& collapse_;
  const WideChooser choose_ = wide_chooser(best_isa());
  std::vector<float> blocks_;  // by number of triangles in a leaf
};

}  // namespace treelet
