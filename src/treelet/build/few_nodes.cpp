#include <treelet/build/few_nodes.h>

#include <algorithm>
#include <array>

namespace treelet {
namespace {

/// The nodes and their order along the axes, one after the other.
class AxisSweep {
 public:
  explicit AxisSweep(std::span<const BinaryNode> nodes) : nodes_(nodes) {
    for (std::size_t i = 0; i < nodes.size(); ++i) boxes_[i] = BoxLanes::load_box(nodes[i]);
  }

  void run(int axis, FewNodesSplit& best) {
    sort(axis);
    const std::size_t count = nodes_.size();
    BoxLanes right = BoxLanes::empty();
    std::uint32_t right_references = 0;
    for (std::size_t i = count; i-- > 1;) {
      right.add(boxes_[order_[i]]);
      right_references += nodes_[order_[i]].count;
      above_[i] = {right, right_references};
    }
    Side left{BoxLanes::empty(), 0};
    std::uint32_t goes_right = (std::uint32_t{1} << count) - 1;
    for (std::size_t i = 1; i < count; ++i) {
      left.box.add(boxes_[order_[i - 1]]);
      left.references += nodes_[order_[i - 1]].count;
      goes_right &= ~(std::uint32_t{1} << order_[i - 1]);
      consider(i, left, above_[i], goes_right, best);
    }
  }

 private:
  struct Side {
    BoxLanes box;
    std::uint32_t references;

    float weight() const { return box.half_area() * float(references); }
  };

  /// By insertion; equal centroids keep their order.
  void sort(int axis) {
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      const float centroid = boxes_[i].doubled_centroid()[axis];
      std::size_t at = i;
      for (; at > 0 && centroids_[at - 1] > centroid; --at) {
        centroids_[at] = centroids_[at - 1];
        order_[at] = order_[at - 1];
      }
      centroids_[at] = centroid;
      order_[at] = std::uint8_t(i);
    }
  }

  static void consider(std::size_t position, const Side& left, const Side& right,
                       std::uint32_t goes_right, FewNodesSplit& best) {
    NodeSplit split;
    split.cost = left.weight() + right.weight();
    split.imbalance = std::max(left.references, right.references);
    if (best.split.exists() && !split.better_than(best.split)) return;
    split.left_nodes = std::uint32_t(position);
    split.left_references = left.references;
    split.left = left.box;
    split.right = right.box;
    best = {split, goes_right};
  }

  std::span<const BinaryNode> nodes_;
  std::array<BoxLanes, kFewNodes> boxes_;
  std::array<Side, kFewNodes> above_;
  std::array<float, kFewNodes> centroids_;
  std::array<std::uint8_t, kFewNodes> order_;
};

}  // namespace

FewNodesSplit split_few_nodes(std::span<const BinaryNode> nodes) {
  AxisSweep sweep(nodes);
  FewNodesSplit best;
  for (int axis = 0; axis < 3; ++axis) sweep.run(axis, best);
  return best;
}

}  // namespace treelet
