#include <treelet/primitive/morton_order.h>

#include <treelet/core/launch.cuh>
#include <treelet/primitive/device_references.cuh>

namespace treelet::cuda {
namespace {

__device__ std::uint64_t code_of(const DeviceReferences& references, std::uint32_t i) {
  if (!takes_part(references, i)) return kLeftOutCode;
  const Aabb box = reference_of(references, i).box();
  return morton_code(references.scene->grid, doubled_centroid(box));
}

__global__ void compute_morton_codes(DeviceReferences references, DeviceMortonOrder order) {
  const std::uint32_t i = thread_index();
  if (i >= references.capacity) return;
  order.codes[i] = code_of(references, i);
  order.references[i] = i;
}

}  // namespace

DeviceMortonOrder carve_morton_order(Carver& carver, std::uint32_t capacity) {
  return {carver.take<std::uint64_t>(capacity), carver.take<std::uint32_t>(capacity)};
}

void sort_along_morton_curve(const DeviceReferences& references, const DeviceMortonOrder& order,
                             const SortScratch& scratch, Stream stream) {
  launch(stream, thread_each(references.capacity), compute_morton_codes, references, order);
  sort_pairs(order.codes, order.references, references.capacity, scratch, stream);
}

}  // namespace treelet::cuda
