#pragma once

#include <cstdint>

#include <treelet/layout/wide_collapse.h>

namespace treelet {

/// The keys of an LBVH's leaves, met from left to right. A slot tells half of the range of keys
/// below it: a left child ends at key slot / 2 - 1, a right one begins at slot / 2
/// (build/lbvh_steps.h). So the references of a leaf need not be looked for one by one.
class LeafKeys {
 public:
  /// Begins with the first leaf of a subtree.
  LeafKeys(const WideCollapse& collapse, std::uint32_t root)
      : entries_(collapse.by_slot.data()), next_(find_first(root)) {}

  /// The first key that was not counted yet.
  std::uint32_t next() const { return next_; }

  /// Keys of the next leaf.
  std::uint32_t count(std::uint32_t leaf) {
    const std::uint32_t begin = next_;
    next_ = find_last(leaf) + 1;
    return next_ - begin;
  }

 private:
  static bool is_left_child(std::uint32_t slot) { return slot % 2 == 0 && slot != kRoot; }
  static bool is_right_child(std::uint32_t slot) { return slot % 2 != 0; }

  std::uint32_t find_first(std::uint32_t slot) const {
    while (!is_right_child(slot) && !is_reference(slot)) slot = entries_[slot].index;
    return is_left_child(slot) ? slot / 2 - 1 : slot / 2;
  }
  std::uint32_t find_last(std::uint32_t slot) const {
    while (!is_left_child(slot) && !is_reference(slot)) slot = entries_[slot].index + 1;
    return is_left_child(slot) ? slot / 2 - 1 : slot / 2;
  }
  bool is_reference(std::uint32_t slot) const { return entries_[slot].decision.is_reference(); }

  const CollapsedNode* const entries_;
  std::uint32_t next_;
};

}  // namespace treelet
