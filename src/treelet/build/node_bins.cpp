#include <treelet/build/node_bins.h>

#include <algorithm>
#include <array>
#include <vector>

#include <treelet/core/parallel.h>

namespace treelet {
namespace {

constexpr std::size_t kGrain = 1 << 13;

struct NodeBin {
  BoxLanes box;
  std::uint32_t nodes, references;

  static NodeBin empty() { return {BoxLanes::empty(), 0, 0}; }

  void add(const NodeBin& other) {
    box.add(other.box);
    nodes += other.nodes;
    references += other.references;
  }
};

/// The bins of all axes; only so many of each as the grid has are in use.
struct NodeBins {
  std::array<std::array<NodeBin, kMaxNodeBins>, 3> axis;

  void clear(int bins) {
    for (auto& of_axis : axis) std::fill_n(of_axis.begin(), bins, NodeBin::empty());
  }

  void fill(std::span<const BinaryNode> nodes, const NodeGrid& grid) {
    for (const BinaryNode& node : nodes) {
      const NodeBin added{BoxLanes::load_box(node), 1, node.count};
      const NodeGrid::Bins bins = grid.of(added.box);
      for (int i = 0; i < 3; ++i) axis[std::size_t(i)][std::size_t(bins[i])].add(added);
    }
  }

  void add(const NodeBins& other, int bins) {
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t k = 0; k < std::size_t(bins); ++k) axis[i][k].add(other.axis[i][k]);
    }
  }
};

/// Fills bins a chunk a task, and adds them up in order.
void fill_in_parallel(std::span<const BinaryNode> nodes, const NodeGrid& grid, NodeBins& bins) {
  std::vector<NodeBins> chunks((nodes.size() + kGrain - 1) / kGrain);
  parallel_for_ranges(nodes.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    NodeBins& chunk = chunks[begin / kGrain];
    chunk.clear(grid.bins());
    chunk.fill(nodes.subspan(begin, end - begin), grid);
  });
  for (const NodeBins& chunk : chunks) bins.add(chunk, grid.bins());
}

float weigh(const NodeBin& side) { return side.box.half_area() * float(side.references); }

/// Looks at each plane of an axis with nodes on both sides.
class PlaneSweep {
 public:
  PlaneSweep(std::span<const NodeBin> bins, int axis) : bins_(bins), axis_(axis) {}

  void run(NodeSplit& best) {
    std::array<NodeBin, kMaxNodeBins> above;
    NodeBin sum = NodeBin::empty();
    for (std::size_t k = bins_.size(); k-- > 1;) {
      sum.add(bins_[k]);
      above[k] = sum;
    }
    NodeBin below = NodeBin::empty();
    for (std::size_t k = 1; k < bins_.size(); ++k) {
      if (bins_[k - 1].nodes == 0) continue;  // the same halves as before
      below.add(bins_[k - 1]);
      if (above[k].nodes > 0) consider(int(k), below, above[k], best);
    }
  }

 private:
  void consider(int plane, const NodeBin& below, const NodeBin& above, NodeSplit& best) const {
    NodeSplit split;
    split.cost = weigh(below) + weigh(above);
    split.imbalance = std::max(below.references, above.references);
    if (!split.better_than(best) && best.exists()) return;
    split.axis = axis_;
    split.bin = plane;
    split.left_nodes = below.nodes;
    split.left_references = below.references;
    split.left = below.box;
    split.right = above.box;
    best = split;
  }

  std::span<const NodeBin> bins_;
  int axis_;
};

}  // namespace

NodeGrid::NodeGrid(const BoxLanes& centroids, int bins)
    : lower_(centroids.lower), scale_{}, bins_(bins), can_part_(false) {
  for (int axis = 0; axis < 3; ++axis) {
    const float scale = float(bins) / (centroids.upper[axis] - centroids.lower[axis]);
    // No bins where there is no extent, or less than a float can tell.
    if (!(scale < std::numeric_limits<float>::max())) continue;
    scale_[axis] = scale;
    can_part_ = true;
  }
  lower_[3] = 0.0f;
}

NodeSplit find_node_split(std::span<const BinaryNode> nodes, const NodeGrid& grid) {
  NodeBins bins;
  bins.clear(grid.bins());
  if (nodes.size() <= kGrain) {
    bins.fill(nodes, grid);
  } else {
    fill_in_parallel(nodes, grid, bins);
  }
  NodeSplit best;
  for (int axis = 0; axis < 3; ++axis) {
    if (!grid.can_part(axis)) continue;
    const std::span<const NodeBin> of_axis(bins.axis[std::size_t(axis)]);
    PlaneSweep(of_axis.first(std::size_t(grid.bins())), axis).run(best);
  }
  return best;
}

}  // namespace treelet
