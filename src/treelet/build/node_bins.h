#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include <treelet/core/box_lanes.h>
#include <treelet/tree/binary_tree.h>

// Where a set of nodes is parted best, judged at planes between equal bins of their centroids along
// all three axes [Wald2007]. Costs are areas times references, summed over the two sides.

namespace treelet {

/// Bins of an axis.
constexpr int kMinNodeBins = 2, kMaxNodeBins = 128;

/// The bins of nodes along all axes: equal parts of the box of their doubled centroids.
class NodeGrid {
 public:
  using Bins = std::int32_t __attribute__((vector_size(16)));

  NodeGrid(const BoxLanes& centroids, int bins);

  int bins() const { return bins_; }
  /// Whether there is an axis that tells the centroids apart.
  bool can_part() const { return can_part_; }
  bool can_part(int axis) const { return scale_[axis] > 0.0f; }
  /// One a lane, of all axes.
  Bins of(const BoxLanes& box) const {
    const BoxLanes::Floats at = (box.doubled_centroid() - lower_) * scale_;
    const BoxLanes::Floats last = BoxLanes::Floats{} + float(bins_ - 1);
    return __builtin_convertvector(at < last ? at : last, Bins);
  }

 private:
  BoxLanes::Floats lower_, scale_;
  int bins_;
  bool can_part_;
};

/// Nodes in bins before `bin` go to the left.
struct NodeSplit {
  float cost = std::numeric_limits<float>::infinity();
  int axis = 0, bin = 0;
  std::uint32_t left_nodes = 0, left_references = 0;
  std::uint32_t imbalance = 0;  ///< decides between equal costs
  BoxLanes left = BoxLanes::empty(), right = BoxLanes::empty();

  bool exists() const { return left_nodes > 0; }
  bool better_than(const NodeSplit& other) const {
    return cost != other.cost ? cost < other.cost : imbalance < other.imbalance;
  }
};

/// The best split; exists wherever the grid can part the nodes. Large sets are binned in parallel.
NodeSplit find_node_split(std::span<const BinaryNode> nodes, const NodeGrid& grid);

}  // namespace treelet
