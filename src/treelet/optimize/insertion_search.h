#pragma once

#include <cstdint>
#include <vector>

#include <treelet/optimize/linked_tree.h>

namespace treelet {

/// Looks for the best place for a subtree that is not in the tree.
class InsertionSearch {
 public:
  explicit InsertionSearch(const LinkedTree& tree) : tree_(tree) {}

  /// The slot beside which a subtree with this box enlarges the areas of internal nodes least.
  std::uint32_t find(const Aabb& box);
  /// That growth: of all ancestors, and the new parent's whole area.
  float growth() const { return best_growth_; }

 private:
  struct Candidate {
    float growth;  ///< of the nodes above the slot
    std::uint32_t slot;

    /// For a heap with the least growth on top.
    bool operator<(const Candidate& other) const {
      return growth != other.growth ? growth > other.growth : slot > other.slot;
    }
  };

  const LinkedTree& tree_;
  std::vector<Candidate> queue_;
  float best_growth_ = 0.0f;
};

}  // namespace treelet
