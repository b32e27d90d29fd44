#pragma once

#include <cstdint>
#include <vector>

#include <treelet/optimize/linked_tree.h>

namespace treelet {

/// Where a node would go: beside `to`, under a new parent of both.
struct Reinsertion {
  std::uint32_t from = kRoot, to = kRoot;
  float gain = 0.0f;  ///< half area that the internal nodes lose in all; 0 where nothing helps
};

/// Looks for the best place for a node among all places of the tree.
class ReinsertionSearch {
 public:
  explicit ReinsertionSearch(const LinkedTree& tree) : tree_(tree) {}

  /// Of any node but the root.
  Reinsertion find(std::uint32_t from);

 private:
  struct Candidate {
    std::uint32_t slot;
    float added;  ///< half area by which nodes between the pivot and the slot grow
  };

  void consider(std::uint32_t to, float gain);
  void search_below(std::uint32_t root, float saved);

  const LinkedTree& tree_;
  std::vector<Candidate> stack_;
  Aabb box_{};
  float area_ = 0.0f;
  Reinsertion best_;
};

}  // namespace treelet
