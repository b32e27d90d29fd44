#pragma once

#include <cstddef>
#include <cstdint>

#include <treelet/core/stream.h>
#include <treelet/layout/device_layout.h>
#include <treelet/tree/sah.h>

namespace treelet::cuda {

/// End-point overlap as on the host (layout/epo.h), to the last bit. The layout's faces are below
/// face_count. Takes scratch of its own, some 40 bytes a face, and waits for the result.
double compute_epo(const DeviceBvh2& bvh, const SahModel& sah, std::uint32_t face_count,
                   Stream stream, std::size_t max_triangles = 0);
double compute_epo(const DeviceBvh8& bvh, const SahModel& sah, std::uint32_t face_count,
                   Stream stream, std::size_t max_triangles = 0);
double compute_epo(const DeviceCwbvh& bvh, const SahModel& sah, std::uint32_t face_count,
                   Stream stream, std::size_t max_triangles = 0);

}  // namespace treelet::cuda
