#pragma once

#include <treelet/core/stream.h>
#include <treelet/layout/device_layout.h>
#include <treelet/query/device_all_hits.h>
#include <treelet/query/device_points.h>

namespace treelet::cuda {

// The CPU's answers, bit for bit (query/contains.h), in device memory. Enqueued on the stream;
// nothing waits.

template <class Layout>
void contains(const Layout& bvh, const TreeFacts& facts, const DevicePointBatch& points,
              bool* answers, Stream stream);

template <class Layout>
void signed_distance(const Layout& bvh, const TreeFacts& facts, const DevicePointBatch& points,
                     float* answers, Stream stream);

}  // namespace treelet::cuda
