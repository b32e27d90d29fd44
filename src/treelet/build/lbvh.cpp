#include <treelet/build/lbvh.h>

#include <vector>

#include <treelet/build/lbvh_steps.h>
#include <treelet/core/parallel.h>
#include <treelet/core/stage.h>
#include <treelet/primitive/morton_order.h>
#include <treelet/tree/bottom_up.h>

// Nodes and boxes in one pass. The crown of the tree comes from the top, by splitting ranges of
// keys; each subtree below it is one task, which goes through its keys once and finishes every node
// when its last key has come [Apetrei2014]: what is written is still in the cache when its parent
// needs it. The nodes are those of emit_nodes (build/lbvh_steps.h), slot for slot.

namespace treelet {
namespace {

/// A range of keys and the node over it.
struct RangeNode {
  KeyRange range;
  BinaryNode node;
};

BinaryNode join(const BinaryNode& left, const BinaryNode& right, std::int64_t split) {
  const Aabb box = merge(left.box(), right.box());
  return {box.lower, left_child_slot(split), box.upper, left.count + right.count};
}

class Emission {
 public:
  Emission(const References& references, const MortonOrder& order, BinaryTree& tree)
      : items_(references.items), order_(order.references), keys_{order.codes}, tree_(tree) {}

  void run() {
    if (tree_.empty()) return;
    split_crown();
    parallel_for(crown_.size(), kCrownGrain, [&](std::size_t i) {
      if (!is_top(crown_[i])) emit_subtree(crown_[i]);
    });
    for (std::size_t i = crown_.size(); i-- > 0;) {
      if (is_top(crown_[i])) emit_top(crown_[i]);
    }
  }

 private:
  static bool is_top(const KeyRange& range) { return range.count() > kSubtreeReferences; }

  /// As list_crown (tree/bottom_up.h), before there are nodes.
  void split_crown() {
    crown_.push_back({0, keys_.size() - 1, -1, -1});
    for (std::size_t i = 0; i < crown_.size(); ++i) {
      const KeyRange range = crown_[i];
      if (!is_top(range)) continue;
      const std::int64_t split = keys_.find_split(range.first, range.last);
      const int shared = keys_.common_prefix(split, split + 1);
      crown_.push_back({range.first, split, range.before, shared});
      crown_.push_back({split + 1, range.last, shared, range.after});
    }
  }

  void emit_subtree(const KeyRange& subtree) {
    std::vector<RangeNode> waiting;  // left children, whose siblings are still to come
    int before = subtree.before;
    for (std::int64_t i = subtree.first; i <= subtree.last; ++i) {
      prefetch(i + kPrefetchDistance);
      const int after = keys_.common_prefix(i, i + 1);
      RangeNode next{{i, i, before, after}, make_leaf(i)};
      before = after;
      while (next.range.count() < subtree.count() && !next.range.is_left_child()) {
        write(next);
        next = finish_parent(waiting.back(), next);
        waiting.pop_back();
      }
      write(next);
      waiting.push_back(next);
    }
  }

  void emit_top(const KeyRange& range) {
    const std::int64_t split = keys_.find_split(range.first, range.last);
    const std::uint32_t left = left_child_slot(split);
    write({range, join(tree_.nodes[left], tree_.nodes[left + 1], split)});
  }

  BinaryNode make_leaf(std::int64_t i) const {
    const std::uint32_t reference = order_[std::size_t(i)];
    const Reference& item = items_[reference];
    return {item.lower, reference, item.upper, 1};
  }

  static RangeNode finish_parent(const RangeNode& left, const RangeNode& right) {
    return {{left.range.first, right.range.last, left.range.before, right.range.after},
            join(left.node, right.node, left.range.last)};
  }

  void write(const RangeNode& finished) { tree_.nodes[finished.range.slot()] = finished.node; }

  /// References lie in the order of faces.
  void prefetch(std::int64_t i) const {
    if (i < keys_.size()) TREELET_PREFETCH(&items_[order_[std::size_t(i)]]);
  }
  static constexpr std::int64_t kPrefetchDistance = 24;

  const Array<Reference>& items_;
  const Array<std::uint32_t>& order_;
  const RadixTreeView keys_;
  BinaryTree& tree_;
  std::vector<KeyRange> crown_;
};

}  // namespace

BinaryTree build_lbvh(const References& references) {
  const MortonOrder order = sort_along_morton_curve(references);
  const Stage stage{"emit hierarchy"};
  BinaryTree tree(references.size());
  Emission(references, order, tree).run();
  return tree;
}

}  // namespace treelet
