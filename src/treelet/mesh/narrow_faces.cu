#include <treelet/mesh/narrow_faces.h>

#include <treelet/core/launch.cuh>

namespace treelet::cuda {
namespace {

constexpr std::uint32_t kNoVertex = 0xffffffff;  // indices are below the vertex count, a uint32

__global__ void narrow(const std::int64_t* from, std::uint32_t* to, std::size_t count) {
  const std::size_t step = std::size_t(gridDim.x) * blockDim.x;
  for (std::size_t i = thread_index(); i < count; i += step) {
    const bool fits = from[i] >= 0 && from[i] < std::int64_t(kNoVertex);
    to[i] = fits ? std::uint32_t(from[i]) : kNoVertex;
  }
}

}  // namespace

DeviceArray<Face> narrow_faces(const std::int64_t* indices, std::size_t faces, Stream stream) {
  DeviceArray<Face> narrowed(faces, stream);
  constexpr std::size_t kMaxThreads = std::size_t{1} << 20;
  launch(stream, thread_each(std::min(3 * faces, kMaxThreads)), narrow, indices,
         reinterpret_cast<std::uint32_t*>(narrowed.data()), 3 * faces);
  return narrowed;
}

}  // namespace treelet::cuda
