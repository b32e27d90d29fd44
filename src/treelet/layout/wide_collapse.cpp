#include <treelet/layout/wide_collapse.h>

#include <treelet/core/parallel.h>
#include <treelet/core/stage.h>
#include <treelet/layout/face_counts.h>
#include <treelet/layout/wide_collapse_steps.h>
#include <treelet/tree/bottom_up.h>

namespace treelet {
namespace {

constexpr std::size_t kGrain = 1 << 12;

}  // namespace

Array<WideChoice> collapse_wide(const BinaryTree& tree, const References& references,
                                const WideCostModel& model) {
  const FaceCounts faces(tree, references);
  const Stage stage{"collapse to 8-wide"};
  Array<WideChoice> choices(tree.nodes.size());
  parallel_for(tree.nodes.size(), kGrain, [&](std::size_t slot) {
    const BinaryNode& node = tree.nodes[slot];
    if (node.is_leaf()) choices[slot] = choose_leaf(half_area(node.box()), model);
  });
  visit_bottom_up(tree, kAllInternal, [&](std::uint32_t slot) {
    const BinaryNode& node = tree.nodes[slot];
    choices[slot] = choose_internal(half_area(node.box()), faces[slot], choices[node.left()],
                                    choices[node.right()], model);
  });
  return choices;
}

WideChildren list_wide_children(const BinaryTree& tree, const Array<WideChoice>& choices,
                                std::uint32_t slot) {
  const auto look_up = [&](std::uint32_t below) {
    return WideSubtree{choices[below].decision, tree.nodes[below].left()};
  };
  if (choices[slot].decision.is_leaf) return {{slot}, 1};
  return spread_over_children(look_up(slot), look_up);
}

}  // namespace treelet
