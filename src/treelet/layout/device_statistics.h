#pragma once

#include <treelet/core/stream.h>
#include <treelet/layout/device_layout.h>
#include <treelet/layout/statistics.h>
#include <treelet/tree/sah.h>

namespace treelet::cuda {

/// As compute_statistics on the host, to the last bit, without moving the tree there. Takes little
/// scratch of its own and waits for the result.
TreeStatistics compute_statistics(const DeviceBvh2& bvh, const SahModel& sah, Stream stream);
TreeStatistics compute_statistics(const DeviceBvh8& bvh, const SahModel& sah, Stream stream);
TreeStatistics compute_statistics(const DeviceCwbvh& bvh, const SahModel& sah, Stream stream);

}  // namespace treelet::cuda
