#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include <treelet/optimize/pair_costs.h>
#include <treelet/optimize/treelet_forming.h>

namespace treelet {

/// Lays a solution out over the treelet's own slots. A solution tells of each subset of the leaves
/// its cost and one child's part.
template <class Solution>
class TreeletRewiring {
 public:
  TreeletRewiring(BinaryTree& tree, PairCosts& costs, const Treelet& treelet,
                  const Solution& solution)
      : nodes_(tree.nodes.data()), costs_(costs), treelet_(treelet), solution_(solution) {
    for (std::size_t leaf = 0; leaf < std::size_t(treelet.size); ++leaf) {
      leaves_[leaf] = nodes_[treelet.leaf_slots[leaf]];
    }
  }

  void run(std::uint32_t root) {
    write_topology(root);
    for (std::size_t i = std::size_t(treelet_.size) - 1; i-- > 0;) join_children(i);
  }

 private:
  struct Item {
    std::uint32_t set, slot;
  };

  /// Parents first, left before right: pairs go to internal nodes in this order. No branch depends
  /// on the topology, which no processor could predict.
  void write_topology(std::uint32_t root) {
    stack_[waiting_++] = {(1u << treelet_.size) - 1, root};
    for (std::size_t i = 0; i + 1 < std::size_t(treelet_.size); ++i) {
      const auto [set, slot] = stack_[--waiting_];
      const std::uint32_t part = solution_.part(set), pair = treelet_.pairs[i];
      internal_slots_[i] = slot;
      costs_.set(pair, solution_.cost(set));
      place({part, pair + 1});
      place({set ^ part, pair});
    }
  }

  /// Where there is no leaf, join_children writes later.
  void place(const Item& child) {
    nodes_[child.slot] = leaves_[std::size_t(std::countr_zero(child.set))];
    stack_[waiting_] = child;
    waiting_ += (child.set & (child.set - 1)) != 0;
  }

  void join_children(std::size_t i) {
    const std::uint32_t pair = treelet_.pairs[i];
    const BinaryNode &left = nodes_[pair], &right = nodes_[pair + 1];
    const Aabb box = merge(left.box(), right.box());
    nodes_[internal_slots_[i]] = {box.lower, pair, box.upper, left.count + right.count};
  }

  BinaryNode* nodes_;
  PairCosts& costs_;
  const Treelet& treelet_;
  const Solution& solution_;
  std::array<BinaryNode, kMaxTreeletSize> leaves_;
  std::array<std::uint32_t, kMaxTreeletSize - 1> internal_slots_;
  std::array<Item, kMaxTreeletSize + 1> stack_;  // disjoint subsets: at most one a leaf
  std::size_t waiting_ = 0;
};

}  // namespace treelet
