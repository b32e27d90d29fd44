#include <treelet/build/lbvh.h>

#include <cstring>

#include <treelet/build/lbvh_emission.h>
#include <treelet/core/box_lanes.h>
#include <treelet/core/stage.h>

namespace treelet {
namespace {

/// Nodes of a binary tree, written in pairs.
class TreeNodes {
 public:
  /// A BinaryNode in two registers.
  using Value = BoxLanes;

  TreeNodes(const References& references, BinaryTree& tree)
      : items_(references.items.data()), nodes_(tree.nodes.data()) {}

  void set_leaf(Value& node, std::size_t, std::uint32_t reference) const {
    node = make(BoxLanes::load_box(items_[reference]), reference, 1);
  }
  void join(Value& left, const Value& right, std::uint32_t left_slot) const {
    write(left_slot, left);
    write(left_slot + 1, right);
    left = make(merge(left, right), left_slot, count(left) + count(right));
  }
  void write(std::uint32_t slot, const Value& node) const {
    static_assert(sizeof(Value) == sizeof(BinaryNode));
    std::memcpy(static_cast<void*>(&nodes_[slot]), &node, sizeof(node));
  }
  void prefetch(std::uint32_t reference) const { TREELET_PREFETCH(&items_[reference]); }

 private:
  static Value make(const BoxLanes& box, std::uint32_t index, std::uint32_t count) {
    return {BoxLanes::with_number(box.lower, index), BoxLanes::with_number(box.upper, count)};
  }
  static std::uint32_t count(const Value& node) { return BoxLanes::number(node.upper); }

  const Reference* const items_;
  BinaryNode* const nodes_;
};

}  // namespace

BinaryTree build_lbvh(const References& references) {
  const MortonOrder order = sort_along_morton_curve(references);
  const Stage stage{"emit hierarchy"};
  BinaryTree tree(references.size());
  if (tree.empty()) return tree;
  const TreeNodes nodes(references, tree);
  nodes.write(kRoot, LbvhEmission(order, nodes).run());
  return tree;
}

}  // namespace treelet
