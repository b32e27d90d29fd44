#include <treelet/layout/leaf_collapse.h>

#include <algorithm>

#include <treelet/core/parallel.h>
#include <treelet/core/stage.h>
#include <treelet/tree/bottom_up.h>

namespace treelet {
namespace {

constexpr std::size_t kGrain = 1 << 14;

/// Decides one subtree after its children.
class CollapseStep {
 public:
  CollapseStep(const BinaryTree& tree, const References& references, const SahModel& sah)
      : tree_(tree), references_(references), sah_(sah), costs_(tree.nodes.size()) {
    const std::size_t slots = tree.nodes.size();
    collapse_ = {Array<std::uint8_t>(slots), Array<std::uint32_t>(slots),
                 Array<std::uint32_t>(slots)};
  }

  void start_leaf(std::size_t slot) {
    set(slot, true, 0, 1);
    costs_[slot] = sah_.leaf_cost(half_area(tree_.nodes[slot].box()), 1);
  }

  void decide(std::uint32_t slot) {
    const BinaryNode& node = tree_.nodes[slot];
    const std::uint32_t left = node.left(), right = node.right();
    const float area = half_area(node.box());
    const float internal = sah_.internal_cost(area, costs_[left] + costs_[right]);
    const std::uint32_t triangles = distinct_triangles(slot);
    const float leaf = sah_.leaf_cost(area, triangles);
    costs_[slot] = min(internal, leaf);
    if (leaf <= internal) {
      set(slot, true, 0, triangles);
    } else {
      set(slot, false, 1 + collapse_.node_count[left] + collapse_.node_count[right],
          collapse_.triangle_count[left] + collapse_.triangle_count[right]);
    }
  }

  LeafCollapse take() { return std::move(collapse_); }

 private:
  void set(std::size_t slot, bool is_leaf, std::uint32_t nodes, std::uint32_t triangles) {
    collapse_.is_leaf[slot] = is_leaf;
    collapse_.node_count[slot] = nodes;
    collapse_.triangle_count[slot] = triangles;
  }

  std::uint32_t distinct_triangles(std::uint32_t slot) const {
    const std::uint32_t count = tree_.nodes[slot].count;
    if (count > sah_.leaf_limit || !references_.may_repeat_faces) return count;
    return std::uint32_t(LeafFaces(tree_, references_).collect(slot).size());
  }

  const BinaryTree& tree_;
  const References& references_;
  const SahModel& sah_;
  Array<float> costs_;
  LeafCollapse collapse_;
};

}  // namespace

LeafCollapse collapse_leaves(const BinaryTree& tree, const References& references,
                             const SahModel& sah) {
  const Stage stage{"collapse leaves"};
  CollapseStep step(tree, references, sah);
  parallel_for(tree.nodes.size(), kGrain, [&](std::size_t slot) {
    if (tree.nodes[slot].is_leaf()) step.start_leaf(slot);
  });
  visit_bottom_up(tree, kAllInternal, [&](std::uint32_t slot) { step.decide(slot); });
  return step.take();
}

std::span<const std::uint32_t> LeafFaces::collect(std::uint32_t root) {
  faces_.clear();
  stack_.assign(1, root);
  while (!stack_.empty()) {
    const BinaryNode& node = nodes_[stack_.back()];
    stack_.pop_back();
    if (!node.is_leaf()) {
      stack_.push_back(node.right());
      stack_.push_back(node.left());
      continue;
    }
    const std::uint32_t face = references_.items[node.index].face;
    const bool is_repeated = references_.may_repeat_faces &&
                             std::find(faces_.begin(), faces_.end(), face) != faces_.end();
    if (!is_repeated) faces_.push_back(face);
  }
  return faces_;
}

}  // namespace treelet
