#include <treelet/tree/refit.h>

#include <treelet/core/launch.cuh>
#include <treelet/primitive/device_references.cuh>
#include <treelet/tree/subtree_levels.cuh>
#include <treelet/tree/top_levels.cuh>

namespace treelet::cuda {
namespace {

constexpr unsigned kSubtreeThreads = 256;
constexpr unsigned kTopThreads = 512;

/// Slots of the tree that only the device knows the size of.
__device__ std::uint32_t slot_count(const DeviceTree& tree) { return 2 * *tree.reference_count; }

template <class Visit>
__global__ void visit_subtrees(DeviceTree tree, DeviceCut cut, Visit visit) {
  __shared__ SubtreeLevels levels;
  for_each_subtree(tree, cut, KeepAll{}, levels, [&] { visit_bottom_up(levels, visit); });
}

template <class Visit>
__global__ void visit_top(DeviceCut cut, Visit visit) {
  visit_top_bottom_up(cut, visit);
}

/// Calls visit(slot) for each internal node after those below it.
template <class Visit>
void launch_bottom_up(const DeviceTree& tree, const DeviceCut& cut, const Visit& visit,
                      Stream stream) {
  launch(stream, {subtree_blocks(tree.capacity), kSubtreeThreads}, visit_subtrees<Visit>, tree, cut,
         visit);
  launch(stream, {1, kTopThreads}, visit_top<Visit>, cut, visit);
}

struct MergeChildren {
  BinaryNode* nodes;

  __device__ void operator()(std::uint32_t slot) const {
    BinaryNode& node = nodes[slot];
    node.set_box(merge(nodes[node.left()].box(), nodes[node.right()].box()));
  }
};

struct AddCosts {
  const BinaryNode* nodes;
  SubtreeFaces faces;
  SahModel sah;
  float* costs;

  __device__ void operator()(std::uint32_t slot) const {
    const BinaryNode node = nodes[slot];
    costs[slot] = sah.subtree_cost(half_area(node.box()), costs[node.left()] + costs[node.right()],
                                   faces.count(node));
  }
};

__global__ void fit_leaves(DeviceTree tree, DeviceReferences references) {
  const std::uint32_t slot = thread_index();
  if (slot >= slot_count(tree) || !tree.nodes[slot].is_leaf()) return;
  tree.nodes[slot].set_box(reference_of(references, tree.nodes[slot].index).box());
}

__global__ void cost_leaves(DeviceTree tree, SahModel sah, float* costs) {
  const std::uint32_t slot = thread_index();
  if (slot >= slot_count(tree)) return;
  const BinaryNode node = tree.nodes[slot];
  costs[slot] = node.is_leaf() ? sah.leaf_cost(half_area(node.box()), 1) : 0.0f;
}

__device__ double cost_of_root(const DeviceTree& tree, const float* costs) {
  if (*tree.reference_count == 0) return 0.0;
  const double root_area = half_area(tree.nodes[kRoot].box());
  return root_area > 0.0 ? costs[kRoot] / root_area : 0.0;
}

__global__ void divide_by_root_area(DeviceTree tree, const float* costs, double* cost) {
  *cost = cost_of_root(tree, costs);
}

}  // namespace

void refit(const DeviceTree& tree, const DeviceCut& cut, const DeviceReferences& references,
           Stream stream) {
  launch(stream, thread_each(2 * std::size_t(tree.capacity)), fit_leaves, tree, references);
  launch_bottom_up(tree, cut, MergeChildren{tree.nodes}, stream);
}

void compute_costs(const DeviceTree& tree, const DeviceCut& cut, const SubtreeFaces& faces,
                   const SahModel& sah, float* costs, Stream stream) {
  launch(stream, thread_each(2 * std::size_t(tree.capacity)), cost_leaves, tree, sah, costs);
  launch_bottom_up(tree, cut, AddCosts{tree.nodes, faces, sah, costs}, stream);
}

void normalize_cost(const DeviceTree& tree, const float* costs, double* cost, Stream stream) {
  launch(stream, {1, 1}, divide_by_root_area, tree, costs, cost);
}

}  // namespace treelet::cuda
