#include <treelet/optimize/treelet_forming.h>

namespace treelet {
namespace {

constexpr float kNeverOpened = -1.0f;  // below every area

/// A treelet and the area of each leaf that can be opened.
class Growth {
 public:
  Growth(const BinaryTree& tree, std::uint32_t root) : tree_(tree) {
    treelet_.size = 1;
    open(0, root);
  }

  const Treelet& grow(int size) {
    while (treelet_.size < size) {
      const int leaf = find_largest();
      if (area_[std::size_t(leaf)] == kNeverOpened) break;
      open(leaf, treelet_.leaf_slots[std::size_t(leaf)]);
    }
    return treelet_;
  }

 private:
  int find_largest() const {
    int largest = 0;
    for (int leaf = 1; leaf < treelet_.size; ++leaf) {
      if (area_[std::size_t(leaf)] > area_[std::size_t(largest)]) largest = leaf;
    }
    return largest;
  }

  void open(int leaf, std::uint32_t slot) {
    const BinaryNode& node = tree_.nodes[slot];
    treelet_.pairs[std::size_t(treelet_.size - 1)] = node.index;
    set(leaf, node.left());
    set(treelet_.size++, node.right());
  }

  void set(int leaf, std::uint32_t slot) {
    const BinaryNode& node = tree_.nodes[slot];
    treelet_.leaf_slots[std::size_t(leaf)] = slot;
    area_[std::size_t(leaf)] = node.is_leaf() ? kNeverOpened : half_area(node.box());
  }

  const BinaryTree& tree_;
  Treelet treelet_;
  std::array<float, kMaxTreeletSize> area_;
};

}  // namespace

Treelet form_treelet(const BinaryTree& tree, std::uint32_t root, int size) {
  return Growth(tree, root).grow(size);
}

TreeletLeaves gather_leaves(const BinaryTree& tree, const PairCosts& costs,
                            const Treelet& treelet) {
  TreeletLeaves leaves;
  leaves.size = treelet.size;
  for (int leaf = 0; leaf < treelet.size; ++leaf) {
    const std::size_t i = std::size_t(leaf);
    const std::uint32_t slot = treelet.leaf_slots[i];
    leaves.box[i] = tree.nodes[slot].box();
    leaves.cost[i] = costs.of(tree.nodes[slot]);
    leaves.count[i] = tree.nodes[slot].count;
  }
  return leaves;
}

}  // namespace treelet
