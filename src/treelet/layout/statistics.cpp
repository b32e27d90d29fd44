#include <treelet/layout/statistics.h>

namespace treelet {
namespace {

void count_leaf(TreeStatistics& statistics, std::uint32_t triangles) {
  ++statistics.leaves;
  if (statistics.leaf_histogram.size() <= triangles) {
    statistics.leaf_histogram.resize(triangles + 1);
  }
  ++statistics.leaf_histogram[triangles];
}

/// Of a child, without what lies below it.
double own_cost(const Bvh2Node& node, int child, const SahModel& sah) {
  const double weight = node.is_leaf(child) ? double(sah.intersection_cost) * node.count[child]
                                            : double(sah.traversal_cost);
  return weight * half_area_double(node.box[child]);
}

}  // namespace

TreeStatistics compute_statistics(const Bvh2& bvh, const SahModel& sah) {
  TreeStatistics statistics;
  statistics.nodes = bvh.nodes.size();
  statistics.triangles = bvh.triangles.size();
  statistics.bytes = bvh.bytes();
  statistics.depth = bvh.depth;
  double cost = 0.0;
  for (const Bvh2Node& node : bvh.nodes) {
    for (const int child : {0, 1}) {
      if (node.is_leaf(child)) count_leaf(statistics, node.count[child]);
      cost += own_cost(node, child, sah);
    }
  }
  const double root_area = half_area_double(bvh.bounds);
  if (!bvh.is_single_leaf()) cost += sah.traversal_cost * root_area;  // no parent holds the root
  statistics.sah = root_area > 0.0 ? cost / root_area : 0.0;
  return statistics;
}

}  // namespace treelet
