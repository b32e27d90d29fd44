#include <treelet/query/ray_order.h>

#include <utility>

#include <treelet/primitive/device_sort.h>
#include <treelet/query/ray_order_steps.h>
#include <treelet/core/launch.cuh>

namespace treelet::cuda {
namespace {

__global__ void write_ray_keys(const Aabb* bounds, DeviceRayBatch rays, std::uint32_t* keys,
                               std::uint32_t* indices) {
  const std::uint32_t i = thread_index();
  if (i >= rays.size) return;
  keys[i] = ray_key(make_ray_grid(*bounds), rays[i]);
  indices[i] = i;
}

}  // namespace

DeviceArray<std::uint32_t> order_rays(const Aabb* bounds, const DeviceRayBatch& rays,
                                      Stream stream) {
  DeviceArray<std::uint32_t> keys(rays.size, stream), indices(rays.size, stream);
  launch(stream, thread_each(rays.size), write_ray_keys, bounds, rays, keys.data(), indices.data());
  return sort_values(std::move(keys), std::move(indices));
}

}  // namespace treelet::cuda
