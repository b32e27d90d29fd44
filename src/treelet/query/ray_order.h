#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include <treelet/core/aabb.h>
#include <treelet/core/array.h>
#include <treelet/core/device_array.h>
#include <treelet/query/device_rays.h>
#include <treelet/query/ray_batch.h>

namespace treelet {

/// In which order a batch of rays is traced. The answers are the same, in the places of their rays.
enum class RayOrder {
  given,
  /// Sorted along a curve through the scene and by direction, so that rays traced together meet the
  /// same nodes [Meister2020]. Pays for large batches of incoherent rays.
  coherent
};

/// Rays that are sorted at a time: so many are as coherent as more, and 16 bytes a ray a bound.
constexpr std::size_t kRaysPerOrder = std::size_t{1} << 24;

/// Numbers of rays in the order to trace them (query/ray_order_steps.h), for rays into a scene of
/// these bounds; at most 2^32 rays.
Array<std::uint32_t> order_rays(const Aabb& bounds, const RayBatch& rays);

namespace detail {

/// Calls trace(part, first ray) for parts of at most `part_size` rays, each in an order of its own.
template <class Batch, class Order, class Trace>
void trace_ordered_parts(const Batch& rays, std::size_t part_size, Order&& order_part,
                         Trace&& trace) {
  for (std::size_t first = 0; first < rays.size; first += part_size) {
    Batch part = rays.part(first, std::min(part_size, rays.size - first));
    const auto order = order_part(part);
    part.order = order.data();
    trace(part, first);
  }
}

}  // namespace detail

/// Calls trace(part, first ray) for parts that make up the batch.
template <class Trace>
void trace_in_order(RayOrder order, const Aabb& bounds, const RayBatch& rays, Trace&& trace) {
  if (order == RayOrder::given) return trace(rays, std::size_t{0});
  detail::trace_ordered_parts(
      rays, kRaysPerOrder, [&](const RayBatch& part) { return order_rays(bounds, part); }, trace);
}

}  // namespace treelet

namespace treelet::cuda {

/// As on the host, in device memory, the bounds too. Enqueued; nothing waits. Takes 16 bytes a ray
/// until it is done, and keeps 4.
DeviceArray<std::uint32_t> order_rays(const Aabb* bounds, const DeviceRayBatch& rays,
                                      Stream stream);

template <class Trace>
void trace_in_order(RayOrder order, const Aabb* bounds, const DeviceRayBatch& rays, Stream stream,
                    Trace&& trace) {
  if (order == RayOrder::given) return trace(rays, std::size_t{0});
  treelet::detail::trace_ordered_parts(
      rays, kRaysPerOrder,
      [&](const DeviceRayBatch& part) { return order_rays(bounds, part, stream); }, trace);
}

}  // namespace treelet::cuda
