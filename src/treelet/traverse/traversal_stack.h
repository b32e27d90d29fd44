#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace treelet {

/// Children that wait their turn. A binary traversal leaves at most one waiting a level of the
/// tree, a wide one seven. For a tree that needs more than the inline entries the stack moves to
/// the heap, once a batch.
class TraversalStack {
 public:
  struct Entry {
    std::uint32_t node;
    float enter;  ///< slab t where the ray enters it
  };

  explicit TraversalStack(std::size_t capacity) {
    if (capacity > inline_.size()) heap_.resize(capacity);
  }
  TraversalStack(const TraversalStack&) = delete;
  TraversalStack& operator=(const TraversalStack&) = delete;

  Entry* entries() { return heap_.empty() ? inline_.data() : heap_.data(); }

 private:
  std::array<Entry, 192> inline_;
  std::vector<Entry> heap_;
};

}  // namespace treelet
