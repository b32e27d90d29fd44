#include <treelet/layout/face_counts.h>

#include <algorithm>
#include <atomic>
#include <vector>

#include <treelet/core/parallel.h>
#include <treelet/core/stage.h>
#include <treelet/tree/bottom_up.h>

// A subtree holds as many faces as references, less one for each two neighbouring pieces of a face,
// in leaf order, that both lie in it. Two leaves lie in their lowest common ancestor and in all
// nodes above it: so each pair is counted at that ancestor, and sums do the rest.

namespace treelet {
namespace {

constexpr std::size_t kGrain = 1 << 12;

class FaceCounter {
 public:
  FaceCounter(const BinaryTree& tree, const References& references)
      : tree_(tree),
        nodes_(tree.nodes),
        items_(references.items),
        begin_(nodes_.size()),
        parent_(nodes_.size() / 2),
        leaf_(items_.size()),
        counts_(nodes_.size(), 0) {}

  Array<std::uint32_t> count() {
    place_leaves();
    parallel_for_ranges(items_.size(), kGrain,
                        [&](std::size_t begin, std::size_t end) { count_pairs(begin, end); });
    parallel_for(nodes_.size(), kGrain, [&](std::size_t slot) {
      if (nodes_[slot].is_leaf()) counts_[slot] = 1;
    });
    visit_bottom_up(tree_, kAllInternal, [&](std::uint32_t slot) {
      const BinaryNode& node = nodes_[slot];
      counts_[slot] = counts_[node.left()] + counts_[node.right()] - counts_[slot];
    });
    return std::move(counts_);
  }

 private:
  void place_leaves() {
    begin_[kRoot] = 0;
    const TreeCut cut = cut_tree(tree_);
    for (const std::uint32_t slot : cut.top) place_children(slot);
    parallel_for(cut.subtrees.size(), 1, [&](std::size_t i) {
      std::vector<std::uint32_t> nodes;
      list_internal_nodes(tree_, cut.subtrees[i], kAllInternal, nodes);
      for (const std::uint32_t slot : nodes) place_children(slot);
    });
    parallel_for(nodes_.size(), kGrain, [&](std::size_t slot) {
      if (nodes_[slot].is_leaf()) leaf_[nodes_[slot].index] = std::uint32_t(slot);
    });
  }

  void place_children(std::uint32_t slot) {
    const BinaryNode& node = nodes_[slot];
    parent_[node.left() / 2] = slot;
    begin_[node.left()] = begin_[slot];
    begin_[node.right()] = begin_[slot] + nodes_[node.left()].count;
  }

  /// Of the faces whose first piece is in [begin, end).
  void count_pairs(std::size_t begin, std::size_t end) {
    const auto face_of = [&](std::size_t i) { return items_[i].face; };
    std::vector<std::uint32_t> leaves;
    std::size_t i = begin;
    while (i < end && i > 0 && face_of(i) == face_of(i - 1)) ++i;
    while (i < end) {
      leaves.clear();
      const std::uint32_t face = face_of(i);
      for (; i < items_.size() && face_of(i) == face; ++i) leaves.push_back(leaf_[i]);
      if (leaves.size() > 1) count_pairs_of(leaves);
    }
  }

  void count_pairs_of(std::vector<std::uint32_t>& leaves) {
    std::sort(leaves.begin(), leaves.end(),
              [&](std::uint32_t a, std::uint32_t b) { return begin_[a] < begin_[b]; });
    for (std::size_t i = 1; i < leaves.size(); ++i) {
      const std::uint32_t ancestor = common_ancestor(leaves[i - 1], leaves[i]);
      std::atomic_ref(counts_[ancestor]).fetch_add(1, std::memory_order_relaxed);
    }
  }

  std::uint32_t common_ancestor(std::uint32_t left, std::uint32_t right) const {
    std::uint32_t slot = right;
    while (begin_[slot] > begin_[left]) slot = parent_[slot / 2];
    return slot;
  }

  const BinaryTree& tree_;
  const Array<BinaryNode>& nodes_;
  const Array<Reference>& items_;
  Array<std::uint32_t> begin_;   // by slot: leaves to the left of the subtree
  Array<std::uint32_t> parent_;  // by pair
  Array<std::uint32_t> leaf_;    // by reference: its slot
  Array<std::uint32_t> counts_;  // by slot: pairs at first, then faces
};

}  // namespace

FaceCounts::FaceCounts(const BinaryTree& tree, const References& references) : nodes_(tree.nodes) {
  if (!references.may_repeat_faces || tree.empty()) return;
  const Stage stage{"count faces"};
  counts_ = FaceCounter(tree, references).count();
}

}  // namespace treelet
