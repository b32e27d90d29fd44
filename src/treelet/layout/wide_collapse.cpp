#include <treelet/layout/wide_collapse.h>

#include <limits>

#include <treelet/core/parallel.h>
#include <treelet/core/stage.h>
#include <treelet/layout/bvh8.h>
#include <treelet/tree/bottom_up.h>

namespace treelet {
namespace {

constexpr std::size_t kGrain = 1 << 12;

float leaf_cost(const BinaryNode& node, const WideCostModel& model) {
  if (node.count > model.leaf_limit) return std::numeric_limits<float>::infinity();
  const std::uint32_t blocks =
      (node.count + TriangleBlock::kTriangles - 1) / TriangleBlock::kTriangles;
  return model.block_cost * half_area(node.box()) * float(blocks);
}

void choose_leaf(const BinaryNode& node, const WideCostModel& model, WideChoice& choice) {
  choice.cost.fill(leaf_cost(node, model));
  choice.is_leaf = true;
  choice.stays_whole = 0xff;
}

/// Least cost of the two sides in `children` children together.
float distribute(const WideChoice& left, const WideChoice& right, int children,
                 std::uint8_t& left_share) {
  float best = std::numeric_limits<float>::infinity();
  for (int share = 1; share < children; ++share) {
    const float cost = left.cost[std::size_t(share)] + right.cost[std::size_t(children - share)];
    if (cost < best) {
      best = cost;
      left_share = std::uint8_t(share);
    }
  }
  return best;
}

void choose_internal(const BinaryNode& node, const WideChoice& left, const WideChoice& right,
                     const WideCostModel& model, WideChoice& choice) {
  constexpr int kWidth = WideChoice::kWidth;
  const float as_leaf = leaf_cost(node, model);
  const float as_node = model.node_cost * half_area(node.box()) +
                        distribute(left, right, kWidth, choice.left_share[kWidth]);
  choice.is_leaf = as_leaf <= as_node;
  choice.cost[1] = choice.is_leaf ? as_leaf : as_node;
  choice.stays_whole = 1 << 1;
  for (int children = 2; children < kWidth; ++children) {
    const std::size_t i = std::size_t(children);
    const float spread = distribute(left, right, children, choice.left_share[i]);
    const bool whole = choice.cost[1] < spread;  // of equal costs, the fuller node
    choice.cost[i] = whole ? choice.cost[1] : spread;
    choice.stays_whole = std::uint8_t(choice.stays_whole | whole << children);
  }
}

}  // namespace

Array<WideChoice> collapse_wide(const BinaryTree& tree, const WideCostModel& model) {
  const Stage stage{"collapse to 8-wide"};
  Array<WideChoice> choices(tree.nodes.size());
  parallel_for(tree.nodes.size(), kGrain, [&](std::size_t slot) {
    if (tree.nodes[slot].is_leaf()) choose_leaf(tree.nodes[slot], model, choices[slot]);
  });
  visit_bottom_up(tree, kAllInternal, [&](std::uint32_t slot) {
    const BinaryNode& node = tree.nodes[slot];
    choose_internal(node, choices[node.left()], choices[node.right()], model, choices[slot]);
  });
  return choices;
}

WideChildren list_wide_children(const BinaryTree& tree, const Array<WideChoice>& choices,
                                std::uint32_t slot) {
  WideChildren children;
  if (choices[slot].is_leaf) {
    children.slots[children.count++] = slot;
    return children;
  }
  struct Item {
    std::uint32_t slot;
    int share;
  };
  std::array<Item, WideChoice::kWidth> stack;  // their shares are disjoint parts of the width
  std::size_t waiting = 0;
  const auto push_sides = [&](std::uint32_t parent, int share) {
    const int left_share = choices[parent].left_share[std::size_t(share)];
    stack[waiting++] = {tree.nodes[parent].right(), share - left_share};
    stack[waiting++] = {tree.nodes[parent].left(), left_share};
  };
  push_sides(slot, WideChoice::kWidth);
  while (waiting > 0) {
    const auto [below, share] = stack[--waiting];
    if ((choices[below].stays_whole >> share & 1) != 0) {
      children.slots[children.count++] = below;
    } else {
      push_sides(below, share);
    }
  }
  return children;
}

}  // namespace treelet
