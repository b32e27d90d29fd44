#pragma once

#include <cstdint>

#include <treelet/layout/layout_access.h>
#include <treelet/tree/sah.h>

namespace treelet {

/// Nodes whose costs make up one partial sum: host and device add in the same order.
constexpr std::uint32_t kStatisticsGrain = 256;

/// What the children of nodes [begin, end) cost themselves, in units of area; calls
/// count_leaf(triangles) for each leaf.
template <class Node, class Item, class CountLeaf>
TREELET_HD double sum_child_costs(const Node* nodes, const Item* items, std::uint32_t begin,
                                  std::uint32_t end, const SahModel& sah,
                                  const CountLeaf& count_leaf) {
  double cost = 0.0;
  for (std::uint32_t node = begin; node < end; ++node) {
    for (int i = 0; i < kChildren<Node>; ++i) {
      double weight = sah.traversal_cost;
      if (is_leaf_child(nodes[node], i)) {
        const std::uint32_t triangles = count_triangles(items, leaf_positions(nodes[node], i));
        count_leaf(triangles);
        weight = double(sah.intersection_cost) * triangles;
      }
      cost += weight * half_area_double(child_box(nodes[node], i));  // unused children are empty
    }
  }
  return cost;
}

/// Cost of a random ray from the sum over all children. No parent holds the root; a tree of a
/// single leaf has no node above it.
template <class Node>
TREELET_HD double relative_cost(double child_costs, const Node& root, const SahModel& sah) {
  const double root_area = half_area_double(node_box(root));
  if (!has_single_child(root)) child_costs += sah.traversal_cost * root_area;
  return root_area > 0.0 ? child_costs / root_area : 0.0;
}

}  // namespace treelet
