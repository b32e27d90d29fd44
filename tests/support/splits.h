#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

#include <treelet/tree/binary_tree.h>

namespace treelet::test {

/// What a split is judged by: areas times references.
struct SplitCost {
  double cost = std::numeric_limits<double>::infinity();
  std::size_t larger_side = 0;  ///< in references

  bool better_than(const SplitCost& other) const {
    return cost != other.cost ? cost < other.cost : larger_side < other.larger_side;
  }
};

/// The cost of parting nodes by a predicate, infinite where a side is empty.
template <class GoesRight>
SplitCost cost_of_split(const std::vector<BinaryNode>& nodes, GoesRight&& goes_right) {
  Aabb box[2] = {Aabb::empty(), Aabb::empty()};
  std::size_t references[2] = {0, 0};
  for (const BinaryNode& node : nodes) {
    const int side = goes_right(node) ? 1 : 0;
    box[side] = merge(box[side], node.box());
    references[side] += node.count;
  }
  if (references[0] == 0 || references[1] == 0) return {};
  return {double(half_area(box[0])) * double(references[0]) +
              double(half_area(box[1])) * double(references[1]),
          std::max(references[0], references[1])};
}

}  // namespace treelet::test
