#include <treelet/mesh/narrow_faces.h>

#include <treelet/core/no_cuda.h>

namespace treelet::cuda {

DeviceArray<Face> narrow_faces(const std::int64_t*, std::size_t, Stream) { throw_no_cuda(); }

}  // namespace treelet::cuda
