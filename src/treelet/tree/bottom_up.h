#pragma once

#include <span>
#include <vector>

#include <treelet/core/parallel.h>
#include <treelet/tree/binary_tree.h>

namespace treelet {

/// The tree cut into a top and the subtrees below it, which threads can take one by one.
struct TreeCut {
  std::vector<std::uint32_t> top;       ///< internal nodes above the cut, parents first
  std::vector<std::uint32_t> subtrees;  ///< roots below the cut, from left to right
};

/// References of a subtree below the cut, at most. A constant, so that what a subtree is never
/// depends on the machine.
constexpr std::uint32_t kSubtreeReferences = 4096;

/// A min_count that all internal nodes have.
constexpr std::uint32_t kAllInternal = 2;

/// Reads only the counts.
TreeCut cut_tree(const BinaryTree& tree);

/// Internal nodes of the subtree at `root` with at least min_count references, parents first.
void list_internal_nodes(const BinaryTree& tree, std::uint32_t root, std::uint32_t min_count,
                         std::vector<std::uint32_t>& nodes);

/// A list of internal nodes by level: those of level k are [ends[k - 1], ends[k]) of nodes. No node
/// of a level is below another of the same level.
struct LevelOrder {
  std::vector<std::uint32_t> nodes;
  std::vector<std::size_t> ends;
};

/// Puts nodes into levels: a node's level is one above its children's. `nodes` are all nodes of at
/// least min_count references in one part of the tree, parents first; levels holds scratch by slot.
LevelOrder order_by_level(const BinaryTree& tree, std::uint32_t min_count,
                          std::span<const std::uint32_t> nodes, Array<std::uint32_t>& levels);

/// Calls visit(slot) for each internal node of at least min_count references, after its children.
/// Nodes of different subtrees are visited at the same time. The visitor may rearrange the nodes
/// below its own slot: all that is still to be visited lies elsewhere or above.
/// Differs from [Karras2012 s4]: a subtree a task instead of a thread a leaf and atomic counters.
/// The order within a subtree is the same post-order, and no parent links are needed.
template <class Visit>
void visit_bottom_up(const BinaryTree& tree, std::uint32_t min_count, Visit&& visit) {
  const TreeCut cut = cut_tree(tree);
  parallel_for_ranges(cut.subtrees.size(), 1, [&](std::size_t begin, std::size_t) {
    std::vector<std::uint32_t> nodes;
    list_internal_nodes(tree, cut.subtrees[begin], min_count, nodes);
    for (auto node = nodes.rbegin(); node != nodes.rend(); ++node) visit(*node);
  });
  for (auto node = cut.top.rbegin(); node != cut.top.rend(); ++node) {
    if (tree.nodes[*node].count >= min_count) visit(*node);
  }
}

/// Calls visit(slots) for each level of nodes, lower ones first.
template <class Visit>
void visit_levels(const LevelOrder& order, Visit&& visit) {
  std::size_t begin = 0;
  for (const std::size_t end : order.ends) {
    visit(std::span(order.nodes).subspan(begin, end - begin));
    begin = end;
  }
}

}  // namespace treelet
