#include <treelet/layout/leaf_collapse.h>

#include <algorithm>

#include <treelet/core/parallel.h>
#include <treelet/core/stage.h>
#include <treelet/layout/face_counts.h>
#include <treelet/layout/leaf_collapse_steps.h>
#include <treelet/tree/bottom_up.h>

namespace treelet {
namespace {

constexpr std::size_t kGrain = 1 << 14;

/// Decides one subtree after its children.
class CollapseStep {
 public:
  CollapseStep(const BinaryTree& tree, const References& references, const SahModel& sah)
      : tree_(tree), sah_(sah), faces_(tree, references), costs_(tree.nodes.size()) {
    const std::size_t slots = tree.nodes.size();
    collapse_ = {Array<std::uint8_t>(slots), Array<std::uint32_t>(slots),
                 Array<std::uint32_t>(slots), 0.0};
  }

  void start_leaf(std::size_t slot) {
    set(slot, true, 0, 1);
    costs_[slot] = sah_.leaf_cost(half_area(tree_.nodes[slot].box()), 1);
  }

  void decide(std::uint32_t slot) {
    const BinaryNode& node = tree_.nodes[slot];
    const std::uint32_t left = node.left(), right = node.right();
    const std::uint32_t triangles = faces_[slot];
    const LeafDecision decision =
        decide_leaf(half_area(node.box()), costs_[left] + costs_[right], triangles, sah_);
    costs_[slot] = decision.cost;
    if (decision.is_leaf) {
      set(slot, true, 0, triangles);
    } else {
      set(slot, false, 1 + collapse_.node_count[left] + collapse_.node_count[right],
          collapse_.triangle_count[left] + collapse_.triangle_count[right]);
    }
  }

  void run() {
    parallel_for(tree_.nodes.size(), kGrain, [&](std::size_t slot) {
      if (tree_.nodes[slot].is_leaf()) start_leaf(slot);
    });
    visit_bottom_up(tree_, kAllInternal, [&](std::uint32_t slot) { decide(slot); });
    const double root_area = tree_.empty() ? 0.0 : half_area(tree_.nodes[kRoot].box());
    if (root_area > 0.0) collapse_.sah = costs_[kRoot] / root_area;
  }

  LeafCollapse take() { return std::move(collapse_); }

 private:
  void set(std::size_t slot, bool is_leaf, std::uint32_t nodes, std::uint32_t triangles) {
    collapse_.is_leaf[slot] = is_leaf;
    collapse_.node_count[slot] = nodes;
    collapse_.triangle_count[slot] = triangles;
  }

  const BinaryTree& tree_;
  const SahModel& sah_;
  const FaceCounts faces_;
  Array<float> costs_;
  LeafCollapse collapse_;
};

}  // namespace

LeafCollapse collapse_leaves(const BinaryTree& tree, const References& references,
                             const SahModel& sah) {
  const Stage stage{"collapse leaves"};
  CollapseStep step(tree, references, sah);
  step.run();
  return step.take();
}

double collapsed_sah_cost(const BinaryTree& tree, const References& references,
                          const SahModel& sah) {
  return collapse_leaves(tree, references, sah).sah;
}

void LeafFaces::append_references(std::uint32_t root, std::vector<std::uint32_t>& references) {
  stack_.assign(1, root);
  while (!stack_.empty()) {
    const BinaryNode& node = nodes_[stack_.back()];
    stack_.pop_back();
    if (node.is_leaf()) {
      references.push_back(node.index);
    } else if (node.count == 2) {  // most internal nodes: no need to come back for their children
      references.push_back(nodes_[node.left()].index);
      references.push_back(nodes_[node.right()].index);
    } else {
      stack_.push_back(node.right());
      stack_.push_back(node.left());
    }
  }
}

std::uint32_t LeafFaces::append(std::uint32_t root, std::vector<std::uint32_t>& faces) {
  const std::size_t begin = faces.size();
  append_references(root, faces);
  return look_up_once(references_, faces, begin);
}

std::uint32_t look_up_once(const References& references, std::vector<std::uint32_t>& numbers,
                           std::size_t begin) {
  std::size_t end = begin;
  for (std::size_t i = begin; i < numbers.size(); ++i) {
    const std::uint32_t face = references.face(numbers[i]);
    const auto first = numbers.begin() + std::ptrdiff_t(begin),
               last = numbers.begin() + std::ptrdiff_t(end);
    const bool is_repeated = references.may_repeat_faces && std::find(first, last, face) != last;
    if (!is_repeated) numbers[end++] = face;
  }
  numbers.resize(end);
  return std::uint32_t(end - begin);
}

void look_up_faces(const References& references, std::span<std::uint32_t> numbers) {
  if (references.are_all_faces()) return;
  constexpr std::size_t kDistance = 16;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const std::size_t ahead = std::min(i + kDistance, numbers.size() - 1);
    if (ahead > i) TREELET_PREFETCH(&references.items[numbers[ahead]].face);
    numbers[i] = references.items[numbers[i]].face;
  }
}

}  // namespace treelet
