#include <treelet/core/device_memory.h>

#include <treelet/core/no_cuda.h>

namespace treelet::cuda {

void* allocate_device_bytes(std::size_t, Stream) { throw_no_cuda(); }
void free_device_bytes(void*, Stream) noexcept {}
void release_device_memory() { throw_no_cuda(); }
void copy_to_device(void*, const void*, std::size_t, Stream) { throw_no_cuda(); }
void copy_to_host(void*, const void*, std::size_t, Stream) { throw_no_cuda(); }
void copy_on_device(void*, const void*, std::size_t, Stream) { throw_no_cuda(); }
void fill_device_bytes(void*, unsigned char, std::size_t, Stream) { throw_no_cuda(); }
void synchronize(Stream) { throw_no_cuda(); }
void synchronize_device() noexcept {}

}  // namespace treelet::cuda
