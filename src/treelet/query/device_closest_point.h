#pragma once

#include <cstddef>

#include <treelet/core/stream.h>
#include <treelet/layout/device_layout.h>
#include <treelet/query/closest_point.h>
#include <treelet/query/device_points.h>

namespace treelet::cuda {

/// The CPU's answers, bit for bit (query/closest_point.h), to arrays in device memory; null ones
/// are not wanted. `depth` is the layout's. Enqueued on the stream; nothing waits.
template <class Layout>
void closest_point(const Layout& bvh, std::size_t depth, const DevicePointBatch& points,
                   const ClosestPointArrays& answers, Stream stream);

}  // namespace treelet::cuda
