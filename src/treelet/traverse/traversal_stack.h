#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace treelet {

/// Far children that wait, at most one a level of the tree. Trees are rarely 60 deep; for one that
/// is deeper than the inline entries the stack moves to the heap, once a batch.
class TraversalStack {
 public:
  struct Entry {
    std::uint32_t node;
    float near;  ///< slab t where the ray enters it
  };

  explicit TraversalStack(std::uint32_t tree_depth) {
    if (tree_depth > inline_.size()) heap_.resize(tree_depth);
  }
  TraversalStack(const TraversalStack&) = delete;
  TraversalStack& operator=(const TraversalStack&) = delete;

  Entry* entries() { return heap_.empty() ? inline_.data() : heap_.data(); }

 private:
  std::array<Entry, 128> inline_;
  std::vector<Entry> heap_;
};

}  // namespace treelet
