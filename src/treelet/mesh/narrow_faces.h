#pragma once

#include <cstddef>
#include <cstdint>

#include <treelet/core/device_array.h>
#include <treelet/mesh/mesh.h>

namespace treelet::cuda {

/// Faces of 64-bit indices in device memory, as torch makes them, as 32-bit ones. An index that
/// does not fit, a negative one too, becomes one that no mesh has and the build then refuses.
DeviceArray<Face> narrow_faces(const std::int64_t* indices, std::size_t faces, Stream stream);

}  // namespace treelet::cuda
