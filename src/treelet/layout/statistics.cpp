#include <treelet/layout/statistics.h>

#include <algorithm>

#include <treelet/layout/statistics_steps.h>

namespace treelet {
namespace {

void count_leaf(TreeStatistics& statistics, std::uint32_t triangles) {
  ++statistics.leaves;
  statistics.triangles += triangles;
  if (statistics.leaf_histogram.size() <= triangles) {
    statistics.leaf_histogram.resize(triangles + 1);
  }
  ++statistics.leaf_histogram[triangles];
}

template <class Node, class Item>
TreeStatistics compute(const Array<Node>& nodes, const Array<Item>& items, const SahModel& sah) {
  TreeStatistics statistics;
  statistics.nodes = nodes.size();
  statistics.bytes = nodes.bytes() + items.bytes();
  double cost = 0.0;
  for (std::size_t begin = 0; begin < nodes.size(); begin += kStatisticsGrain) {
    const std::size_t end = std::min(begin + kStatisticsGrain, nodes.size());
    cost +=
        sum_child_costs(nodes.data(), items.data(), std::uint32_t(begin), std::uint32_t(end), sah,
                        [&](std::uint32_t triangles) { count_leaf(statistics, triangles); });
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

}  // namespace treelet
