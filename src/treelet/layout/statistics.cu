#include <treelet/layout/device_statistics.h>

#include <algorithm>

#include <treelet/core/device_array.h>
#include <treelet/layout/device_collapse.h>
#include <treelet/layout/statistics_steps.h>
#include <treelet/core/launch.cuh>

namespace treelet::cuda {
namespace {

constexpr unsigned kThreads = 64;
constexpr std::uint32_t kBins = kMaxBvh2Leaf + 1;

struct LeafCounts {
  double sah;
  std::uint32_t histogram[kBins];  // leaves by their triangles
};

/// A thread a range of nodes.
template <class Layout>
__global__ void sum_ranges_kernel(Layout bvh, SahModel sah, double* costs, LeafCounts* counts) {
  const std::uint32_t begin = thread_index() * kStatisticsGrain, nodes = bvh.summary->size.nodes;
  if (begin >= nodes) return;
  const std::uint32_t end = nodes - begin < kStatisticsGrain ? nodes : begin + kStatisticsGrain;
  costs[thread_index()] =
      sum_child_costs(bvh.nodes, bvh.items, begin, end, sah, [&](std::uint32_t triangles) {
        if (triangles < kBins) atomicAdd(&counts->histogram[triangles], 1u);
      });
}

template <class Layout>
__global__ void finish_sum_kernel(Layout bvh, SahModel sah, const double* costs,
                                  LeafCounts* counts) {
  const std::uint32_t nodes = bvh.summary->size.nodes;
  if (nodes == 0) return;
  double sum = 0.0;
  for (std::uint32_t i = 0; i * kStatisticsGrain < nodes; ++i) sum += costs[i];
  counts->sah = relative_cost(sum, bvh.nodes[0], sah);
}

template <class Layout>
LeafCounts count_leaves(const Layout& bvh, const SahModel& sah, Stream stream) {
  const std::size_t ranges = bvh.node_capacity / kStatisticsGrain + 1;
  DeviceArray<double> costs(ranges, stream);
  DeviceArray<LeafCounts> counts(1, stream);
  fill_device_bytes(counts.data(), 0, counts.bytes(), stream);
  launch(stream, thread_each(ranges, kThreads), sum_ranges_kernel<Layout>, bvh, sah, costs.data(),
         counts.data());
  launch(stream, Grid{1, 1}, finish_sum_kernel<Layout>, bvh, sah, costs.data(), counts.data());
  return download(counts)[0];
}

template <class Layout>
TreeStatistics compute(const Layout& bvh, const SahModel& sah, Stream stream) {
  const LeafCounts counts = count_leaves(bvh, sah, stream);
  const LayoutSize size = download(bvh.summary, 1, stream)[0].size;
  TreeStatistics statistics;
  statistics.nodes = size.nodes;
  statistics.triangles = size.triangles;
  statistics.bytes =
      size.nodes * sizeof(typename Layout::Node) + size.items * sizeof(typename Layout::Item);
  statistics.depth = size.depth;
  statistics.sah = counts.sah;
  for (std::uint32_t i = 0; i < kBins; ++i) {
    if (counts.histogram[i] == 0) continue;
    statistics.leaves += counts.histogram[i];
    statistics.leaf_histogram.resize(i + 1);
    statistics.leaf_histogram[i] = counts.histogram[i];
  }
  return statistics;
}

}  // namespace

TreeStatistics compute_statistics(const DeviceBvh2& bvh, const SahModel& sah, Stream stream) {
  return compute(bvh, sah, stream);
}
TreeStatistics compute_statistics(const DeviceBvh8& bvh, const SahModel& sah, Stream stream) {
  return compute(bvh, sah, stream);
}
TreeStatistics compute_statistics(const DeviceCwbvh& bvh, const SahModel& sah, Stream stream) {
  return compute(bvh, sah, stream);
}

}  // namespace treelet::cuda
