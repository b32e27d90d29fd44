#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <treelet/build/lbvh_steps.h>
#include <treelet/core/parallel.h>
#include <treelet/primitive/morton_order.h>
#include <treelet/tree/bottom_up.h>

namespace treelet {

/// All nodes of an LBVH, from the bottom up, in one pass over the keys. The crown of the tree comes
/// from the top, by splitting ranges of keys; each subtree below it is one task, which finishes
/// every node when its last key has come [Apetrei2014]: what is written is still in the cache when
/// the parent needs it. The nodes are those of emit_nodes (build/lbvh_steps.h), slot for slot.
///
/// What a node is worth is the user's: nodes.set_leaf(value, key, reference) makes a
/// Value, nodes.join(left, right, slot of the left child) makes the left child's value its
/// parent's.
template <class Nodes>
class LbvhEmission {
 public:
  using Value = typename Nodes::Value;

  LbvhEmission(const MortonOrder& order, const Nodes& nodes)
      : order_(order.references), keys_{order.codes}, nodes_(nodes) {}

  /// The value of the root. There must be keys.
  Value run() {
    split_crown();
    values_.resize(crown_.size());
    parallel_for(crown_.size(), kCrownGrain, [&](std::size_t i) {
      if (!is_top(crown_[i])) emit_subtree(crown_[i], values_[i]);
    });
    std::size_t next = crown_.size();
    for (std::size_t i = crown_.size(); i-- > 0;) {
      if (!is_top(crown_[i])) continue;
      next -= 2;
      const KeyRange left = crown_[next];
      values_[i] = values_[next];
      nodes_.join(values_[i], values_[next + 1], left_child_slot(left.last));
    }
    return values_[0];
  }

  /// Slots of the nodes above the cut, parents first.
  std::vector<std::uint32_t> top_slots() const {
    std::vector<std::uint32_t> slots;
    for (const KeyRange& range : crown_) {
      if (is_top(range)) slots.push_back(range.slot());
    }
    return slots;
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

  /// Nodes that wait for their siblings lie on a stack, from left to right: the first key of each,
  /// how many bits it shares with the key before, and what the node is worth. One that shares more
  /// with the key after it than with the one before is a left child (KeyRange) and waits; any other
  /// is joined to the node before it.
  void emit_subtree(const KeyRange& subtree, Value& root) const {
    std::int64_t first[kMaxDepth];
    int before[kMaxDepth];
    Value values[kMaxDepth];
    int top = -1, before_next = subtree.before;
    for (std::int64_t i = subtree.first; i <= subtree.last; ++i) {
      prefetch(i + kPrefetchDistance);
      const int after = keys_.common_prefix(i, i + 1);
      ++top;
      first[top] = i;
      before[top] = before_next;
      nodes_.set_leaf(values[top], std::size_t(i), order_[std::size_t(i)]);
      before_next = after;
      for (; top > 0 && before[top] >= after; --top) {
        nodes_.join(values[top - 1], values[top], left_child_slot(first[top] - 1));
      }
    }
    root = values[0];
  }

  /// References lie in the order of faces.
  void prefetch(std::int64_t i) const {
    if (i < keys_.size()) nodes_.prefetch(order_[std::size_t(i)]);
  }
  static constexpr std::int64_t kPrefetchDistance = 24;
  /// Each node on a way down shares more bits than the one above: of a code or of an index.
  static constexpr int kMaxDepth = 2 * 64 + 1;

  const Array<std::uint32_t>& order_;
  const RadixTreeView keys_;
  const Nodes& nodes_;
  std::vector<KeyRange> crown_;
  std::vector<Value> values_;
};

}  // namespace treelet
