#include <treelet/layout/statistics.h>

#include <treelet/layout/child_view.h>

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

template <class Layout>
bool is_single_leaf(const Layout& bvh) {
  return bvh.nodes.size() == 1 && child_of(bvh, 0, 1).box.is_empty();
}

template <class Layout>
TreeStatistics compute(const Layout& bvh, const SahModel& sah) {
  TreeStatistics statistics;
  statistics.nodes = bvh.nodes.size();
  statistics.bytes = bvh.bytes();
  statistics.depth = bvh.depth;
  double cost = 0.0;
  for (std::uint32_t node = 0; node < bvh.nodes.size(); ++node) {
    for (int i = 0; i < children_per_node(bvh); ++i) {
      const ChildView child = child_of(bvh, node, i);
      if (child.is_leaf) count_leaf(statistics, count_triangles(bvh, child));
      cost += own_weight(bvh, child, sah) * half_area_double(child.box);
    }
  }
  const double root_area = half_area_double(bvh.bounds);
  if (!is_single_leaf(bvh)) cost += sah.traversal_cost * root_area;  // no parent holds the root
  statistics.sah = root_area > 0.0 ? cost / root_area : 0.0;
  return statistics;
}

}  // namespace

TreeStatistics compute_statistics(const Bvh2& bvh, const SahModel& sah) {
  return compute(bvh, sah);
}
TreeStatistics compute_statistics(const Bvh8& bvh, const SahModel& sah) {
  return compute(bvh, sah);
}

}  // namespace treelet
