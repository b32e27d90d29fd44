// Forms treelets as treelet_forming.cpp does, one a lane: in each step every lane opens its leaf of
// largest area, the first of equals.

#include <treelet/optimize/treelet_lanes.inl>

namespace treelet::TREELET_ISA {
namespace {

/// Costs of nodes from those of their children, of which `pairs` tells once more, in memory.
TREELET_INLINE Float costs_from_children(const BinaryNode* nodes, const NodeLanes& node,
                                         const std::uint32_t* pairs, const float* costs,
                                         const SahLanes& sah) {
  const NodeLanes left = load_nodes(nodes, pairs, 0, sah), right = load_nodes(nodes, pairs, 1, sah);
  return subtree_cost(
      sah, node.box,
      costs_of(left, node.index, costs, sah) + costs_of(right, node.index, costs, sah));
}

TREELET_INLINE void update_lanes(const BinaryNode* nodes, const std::uint32_t* slots,
                                 const SahLanes& sah, float* costs) {
  alignas(64) std::uint32_t pairs[kLanes];
  alignas(64) float updated[kLanes];
  const NodeLanes node = load_nodes(nodes, slots, 0, sah);
  store_ints(pairs, node.index);
  store(updated, costs_from_children(nodes, node, pairs, costs, sah));
  for (int lane = 0; lane < kLanes; ++lane) costs[pairs[lane] / 2] = updated[lane];
}

/// The leaves of treelets while they grow.
class Growth {
 public:
  /// The leaf that each lane opens next and the pair of its children.
  struct Opened {
    Int leaf, pair;
  };

  /// Puts a node into the opened leaf's place.
  TREELET_INLINE void replace(int size, const Opened& opened, Int slots, const NodeLanes& node) {
    const Float areas = area_to_open(node);
    for (int leaf = 0; leaf < size; ++leaf) {
      const Int is_opened = opened.leaf == leaf;
      area_[leaf] = is_opened ? areas : area_[leaf];
      slot_[leaf] = is_opened ? slots : slot_[leaf];
      pair_[leaf] = is_opened ? node.index : pair_[leaf];
    }
  }

  TREELET_INLINE void append(int size, Int slots, const NodeLanes& node) {
    area_[size] = area_to_open(node);
    slot_[size] = slots;
    pair_[size] = node.index;
  }

  TREELET_INLINE Opened find_largest(int size) const {
    Float largest = area_[0];
    Opened opened{Int{}, pair_[0]};
    for (int leaf = 1; leaf < size; ++leaf) {
      const Int is_larger = area_[leaf] > largest;
      largest = max(largest, area_[leaf]);
      opened.leaf = is_larger ? Int{} + leaf : opened.leaf;
      opened.pair = is_larger ? pair_[leaf] : opened.pair;
    }
    return opened;
  }

  TREELET_INLINE Int slots(int leaf) const { return slot_[leaf]; }

 private:
  TREELET_INLINE static Float area_to_open(const NodeLanes& node) {
    const Float never = broadcast<Float>(-1.0f);  // below every area
    return node.is_leaf ? never : half_area(node.box);
  }

  Float area_[kMaxTreeletSize];
  Int slot_[kMaxTreeletSize], pair_[kMaxTreeletSize];
};

TREELET_INLINE void gather_leaf(const BinaryNode* nodes, const float* costs, const SahLanes& sah,
                                int leaf, int lane, TreeletBatch& batch) {
  const NodeLanes node = load_nodes(nodes, &batch.slots[leaf][lane], 0, sah);
  for (int axis = 0; axis < 3; ++axis) {
    store(&batch.lower[axis][leaf][lane], node.box.lower[axis]);
    store(&batch.upper[axis][leaf][lane], node.box.upper[axis]);
  }
  store(&batch.count[leaf][lane], node.box.count);
  store(&batch.cost[leaf][lane], costs_of(node, load_ints(&batch.pairs[0][lane]), costs, sah));
}

TREELET_INLINE void form_lanes(const BinaryNode* nodes, const float* costs, const SahLanes& sah,
                               int lane, TreeletBatch& batch) {
  const NodeLanes root = load_nodes(nodes, &batch.roots[lane], 0, sah);
  store_ints(&batch.pairs[0][lane], root.index);
  store(&batch.root_cost[lane],
        costs_from_children(nodes, root, &batch.pairs[0][lane], costs, sah));
  Growth growth;
  Growth::Opened opened{Int{}, root.index};
  for (int size = 1; size < batch.size; ++size) {
    std::uint32_t* const pairs = &batch.pairs[size - 1][lane];
    store_ints(pairs, opened.pair);
    growth.replace(size, opened, opened.pair, load_nodes(nodes, pairs, 0, sah));
    growth.append(size, opened.pair + 1, load_nodes(nodes, pairs, 1, sah));
    opened = growth.find_largest(size + 1);
  }
  for (int leaf = 0; leaf < batch.size; ++leaf) {
    store_ints(&batch.slots[leaf][lane], growth.slots(leaf));
    gather_leaf(nodes, costs, sah, leaf, lane, batch);
  }
}

}  // namespace
}  // namespace treelet::TREELET_ISA
