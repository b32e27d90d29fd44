#include <treelet/layout/statistics.h>

#include <vector>

#include <treelet/core/parallel.h>
#include <treelet/layout/statistics_steps.h>

namespace treelet {
namespace {

void count_leaves(TreeStatistics& statistics, std::uint32_t triangles, std::size_t leaves) {
  statistics.leaves += leaves;
  statistics.triangles += triangles * leaves;
  if (statistics.leaf_histogram.size() <= triangles) {
    statistics.leaf_histogram.resize(triangles + 1);
  }
  statistics.leaf_histogram[triangles] += leaves;
}

/// What a range of nodes adds.
struct RangeStatistics {
  double cost = 0.0;
  TreeStatistics leaves;
};

template <class Node, class Item>
TreeStatistics compute(const Array<Node>& nodes, const Array<Item>& items, const SahModel& sah) {
  std::vector<RangeStatistics> ranges((nodes.size() + kStatisticsGrain - 1) / kStatisticsGrain);
  parallel_for_ranges(nodes.size(), kStatisticsGrain, [&](std::size_t begin, std::size_t end) {
    RangeStatistics& range = ranges[begin / kStatisticsGrain];
    range.cost =
        sum_child_costs(nodes.data(), items.data(), std::uint32_t(begin), std::uint32_t(end), sah,
                        [&](std::uint32_t triangles) { count_leaves(range.leaves, triangles, 1); });
  });
  TreeStatistics statistics;
  statistics.nodes = nodes.size();
  statistics.bytes = nodes.bytes() + items.bytes();
  double cost = 0.0;
  for (const RangeStatistics& range : ranges) {
    cost += range.cost;
    const auto& histogram = range.leaves.leaf_histogram;
    for (std::uint32_t triangles = 0; triangles < histogram.size(); ++triangles) {
      if (histogram[triangles] > 0) count_leaves(statistics, triangles, histogram[triangles]);
    }
  }
  if (!nodes.empty()) statistics.sah = relative_cost(cost, nodes[0], sah);
  return statistics;
}

}  // namespace

TreeStatistics compute_statistics(const Bvh2& bvh, const SahModel& sah) {
  TreeStatistics statistics = compute(bvh.nodes, bvh.triangles, sah);
  statistics.depth = bvh.depth;
  return statistics;
}
TreeStatistics compute_statistics(const Bvh8& bvh, const SahModel& sah) {
  TreeStatistics statistics = compute(bvh.nodes, bvh.blocks, sah);
  statistics.depth = bvh.depth;
  return statistics;
}
TreeStatistics compute_statistics(const Cwbvh& bvh, const SahModel& sah) {
  TreeStatistics statistics = compute(bvh.nodes, bvh.triangles, sah);
  statistics.depth = bvh.depth;
  return statistics;
}

}  // namespace treelet
