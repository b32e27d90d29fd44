#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include <treelet/optimize/treelet_forming.h>

namespace treelet {

/// Lays a solution out over the treelet's own slots. A solution tells of each subset of the leaves
/// its cost, box, count and one child's part.
template <class Solution>
class TreeletRewiring {
 public:
  TreeletRewiring(BinaryTree& tree, Array<float>& costs, const Treelet& treelet,
                  const Solution& solution)
      : tree_(tree), costs_(costs), treelet_(treelet), solution_(solution) {
    for (std::size_t leaf = 0; leaf < std::size_t(treelet.size); ++leaf) {
      leaves_[leaf] = tree.nodes[treelet.leaf_slots[leaf]];
    }
  }

  void run(std::uint32_t root) {
    struct Item {
      std::uint32_t set, slot;
    };
    std::array<Item, kMaxTreeletSize> stack;  // disjoint subsets: at most one a leaf
    std::size_t waiting = 0;
    stack[waiting++] = {(1u << treelet_.size) - 1, root};
    while (waiting > 0) {
      const auto [set, slot] = stack[--waiting];
      costs_[slot] = solution_.cost(set);
      if (std::has_single_bit(set)) {
        tree_.nodes[slot] = leaves_[std::size_t(std::countr_zero(set))];
        continue;
      }
      const std::uint32_t pair = write_internal(slot, set);
      const std::uint32_t part = solution_.part(set);
      stack[waiting++] = {part, pair + 1};
      stack[waiting++] = {set ^ part, pair};
    }
  }

 private:
  std::uint32_t write_internal(std::uint32_t slot, std::uint32_t set) {
    const std::uint32_t pair = treelet_.pairs[next_pair_++];
    const Aabb box = solution_.box(set);
    tree_.nodes[slot] = {box.lower, pair, box.upper, solution_.count(set)};
    return pair;
  }

  BinaryTree& tree_;
  Array<float>& costs_;
  const Treelet& treelet_;
  const Solution& solution_;
  std::array<BinaryNode, kMaxTreeletSize> leaves_;
  std::size_t next_pair_ = 0;
};

}  // namespace treelet
