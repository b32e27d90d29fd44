#include <treelet/tree/validate.h>

#include <algorithm>

#include <treelet/core/device_array.h>
#include <treelet/core/device_memory.h>
#include <treelet/core/launch.cuh>
#include <treelet/primitive/device_references.cuh>

namespace treelet::cuda {
namespace {

/// What all kernels look at.
struct Validation {
  DeviceTree tree;
  DeviceReferences references;
  ValidateScratch scratch;
  TreeReport* report;

  /// False where the tree is of another size than the references: then nothing else is looked at.
  __device__ bool has_right_size() const { return report->slots == 2 * report->references; }

  /// The first place wins, whatever the order in which places are found.
  __device__ void find(TreeFault fault, std::uint32_t place) const {
    atomicMin(&report->faults[std::uint32_t(fault)].place, place);
  }
};

__device__ TreeReport empty_report(const DeviceTree& tree, const DeviceReferences& references) {
  TreeReport report{};
  const std::uint32_t room = std::min(*tree.reference_count, tree.capacity);
  report.slots = 2 * room;
  report.references = references.scene->reference_count;
  for (TreeReport::First& first : report.faults) first.place = TreeReport::kNowhere;
  return report;
}

__device__ bool is_pair(const Validation& v, std::uint32_t slot) {
  return slot >= 2 && slot % 2 == 0 && slot < v.report->slots;
}

__device__ void check_leaf(const Validation& v, std::uint32_t slot, const BinaryNode& leaf) {
  if (leaf.index >= v.references.capacity || !takes_part(v.references, leaf.index)) {
    return v.find(TreeFault::no_such_reference, slot);
  }
  atomicAdd(&v.scratch.holders[leaf.index], 1u);
  const Aabb box = reference_of(v.references, leaf.index).box();
  if (leaf.box() != box) v.find(TreeFault::wrong_leaf_box, slot);
}

__device__ void check_internal(const Validation& v, std::uint32_t slot, const BinaryNode& node) {
  if (!is_pair(v, node.index)) return v.find(TreeFault::no_such_pair, slot);
  atomicAdd(&v.scratch.parents[node.index / 2], 1u);
  const BinaryNode left = v.tree.nodes[node.left()], right = v.tree.nodes[node.right()];
  if (node.count != left.count + right.count) v.find(TreeFault::wrong_count, slot);
  if (node.box() != merge(left.box(), right.box())) v.find(TreeFault::wrong_box, slot);
}

__device__ void check_slot(const Validation& v, std::uint32_t slot) {
  const BinaryNode node = v.tree.nodes[slot];
  if (node.is_leaf()) {
    check_leaf(v, slot, node);
  } else {
    check_internal(v, slot, node);
  }
}

__device__ void check_pair(const Validation& v, std::uint32_t pair) {
  const std::uint32_t parents = v.scratch.parents[pair / 2];
  if (parents > 1) v.find(TreeFault::two_parents, pair);
  if (parents < 1) v.find(TreeFault::no_parent, pair);
}

__device__ void check_reference(const Validation& v, std::uint32_t reference) {
  const std::uint32_t holders = v.scratch.holders[reference];
  if (holders > 1) v.find(TreeFault::repeated_reference, reference);
  if (holders < 1 && takes_part(v.references, reference)) {
    v.find(TreeFault::missing_reference, reference);
  }
}

__device__ void add_details(const Validation& v) {
  for (std::uint32_t fault = 0; fault < kTreeFaults; ++fault) {
    TreeReport::First& first = v.report->faults[fault];
    if (first.place == TreeReport::kNowhere || fault >= std::uint32_t(TreeFault::two_parents)) {
      continue;
    }
    const BinaryNode& node = v.tree.nodes[first.place];
    const bool names_index = fault == std::uint32_t(TreeFault::no_such_reference) ||
                             fault == std::uint32_t(TreeFault::no_such_pair);
    first.value = names_index ? node.index : node.count;
    if (fault != std::uint32_t(TreeFault::wrong_count)) continue;
    first.children = v.tree.nodes[node.left()].count + v.tree.nodes[node.right()].count;
  }
}

__global__ void begin_report(Validation v) { *v.report = empty_report(v.tree, v.references); }

__global__ void check_slots(Validation v) {
  const std::uint32_t slot = thread_index();
  if (!v.has_right_size() || slot >= v.report->slots || slot == kRoot + 1) return;
  check_slot(v, slot);
}

__global__ void check_pairs(Validation v) {
  const std::uint32_t pair = 2 * thread_index();
  if (!v.has_right_size() || !is_pair(v, pair)) return;
  check_pair(v, pair);
}

__global__ void check_references(Validation v) {
  const std::uint32_t reference = thread_index();
  if (!v.has_right_size() || reference >= v.references.capacity) return;
  check_reference(v, reference);
}

__global__ void end_report(Validation v) { add_details(v); }

}  // namespace

ValidateScratch carve_validate_scratch(Carver& carver, const DeviceTree& tree,
                                       const DeviceReferences& references) {
  return {carver.take<std::uint32_t>(tree.capacity),
          carver.take<std::uint32_t>(references.capacity)};
}

void validate_tree(const DeviceTree& tree, const DeviceReferences& references,
                   const ValidateScratch& scratch, TreeReport* report, Stream stream) {
  const Validation v{tree, references, scratch, report};
  fill_device_bytes(scratch.parents, 0, tree.capacity * sizeof(*scratch.parents), stream);
  fill_device_bytes(scratch.holders, 0, references.capacity * sizeof(*scratch.holders), stream);
  launch(stream, {1, 1}, begin_report, v);
  launch(stream, thread_each(2 * std::size_t(tree.capacity)), check_slots, v);
  launch(stream, thread_each(tree.capacity), check_pairs, v);
  launch(stream, thread_each(references.capacity), check_references, v);
  launch(stream, {1, 1}, end_report, v);
}

std::vector<std::string> validate(const DeviceTree& tree, const DeviceReferences& references,
                                  Stream stream) {
  Carver count;
  carve_validate_scratch(count, tree, references);
  DeviceArray<std::byte> block(count.peak(), stream);
  DeviceArray<TreeReport> report(1, stream);
  Carver carver(block.data());
  const ValidateScratch scratch = carve_validate_scratch(carver, tree, references);
  validate_tree(tree, references, scratch, report.data(), stream);
  return describe(download(report)[0]);
}

}  // namespace treelet::cuda
