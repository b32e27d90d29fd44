#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <treelet/core/device_array.h>
#include <treelet/core/device_scope.h>
#include <treelet/core/use_log.h>

#include "arrays.h"
#include "bindings.h"
#include "device_address.h"

namespace nb = nanobind;
namespace cuda = treelet::cuda;
using namespace nb::literals;

namespace {

/// Device memory that Python owns.
class Memory {
 public:
  Memory(std::size_t bytes, int device, Address stream) : device_(device) {
    const cuda::DeviceScope scope(device);
    bytes_ = cuda::DeviceArray<std::byte>(bytes, stream_of(stream));
  }
  Memory(const Memory&) = delete;
  /// Nobody knows which streams use it: waits for the device, and frees on a stream that is there.
  ~Memory() {
    const cuda::DeviceScope scope(device_);
    cuda::synchronize_device();
    bytes_.free_on(cuda::own_stream());
    bytes_ = {};
  }

  Address address() { return Address(bytes_.data()); }
  std::size_t size() const { return bytes_.size(); }
  void copy_from_host(nb::bytes values, Address stream) {
    require(values.size());
    const cuda::DeviceScope scope(device_);
    cuda::copy_to_device(bytes_.data(), values.data(), values.size(), stream_of(stream));
    cuda::synchronize(stream_of(stream));
  }
  NumpyArray<std::uint8_t> copy_to_host(std::size_t offset, std::size_t bytes, Address stream) {
    if (offset > bytes_.size() || bytes > bytes_.size() - offset) {
      throw std::invalid_argument("not so many bytes are there");
    }
    treelet::Array<std::uint8_t> values(bytes);
    if (bytes > 0) {
      const nb::gil_scoped_release release;
      const cuda::DeviceScope scope(device_);
      cuda::copy_to_host(values.data(), bytes_.data() + offset, bytes, stream_of(stream));
    }
    return as_numpy(std::move(values));
  }

 private:
  void require(std::size_t bytes) const {
    if (bytes != bytes_.size()) throw std::invalid_argument("as many bytes as there are, please");
  }
  int device_;
  cuda::DeviceArray<std::byte> bytes_;
};

nb::dlpack::dtype dtype_of(const std::string& name) {
  if (name == "float32") return nb::dtype<float>();
  if (name == "int32") return nb::dtype<std::int32_t>();
  if (name == "int64") return nb::dtype<std::int64_t>();
  if (name == "uint32") return nb::dtype<std::uint32_t>();
  if (name == "bool") return nb::dtype<bool>();
  throw std::invalid_argument("no array of " + name + " leaves by DLPack");
}

/// An array that only speaks DLPack, for libraries that take that and nothing else. The memory
/// stays while it is used.
nb::ndarray<nb::device::cuda> as_dlpack(nb::handle memory, Address address,
                                        const std::string& dtype,
                                        const std::vector<std::size_t>& shape, int device) {
  return nb::ndarray<nb::device::cuda>(pointer<void>(address), shape.size(), shape.data(), memory,
                                       nullptr, dtype_of(dtype), nb::device::cuda::value, device);
}

}  // namespace

void bind_device_memory(nb::module_& module) {
  nb::class_<Memory>(module, "DeviceMemory")
      .def(nb::init<std::size_t, int, Address>(), "bytes"_a, "device"_a, "stream"_a)
      .def_prop_ro("address", &Memory::address)
      .def("__len__", &Memory::size)
      .def("copy_from_host", &Memory::copy_from_host, "values"_a, "stream"_a)
      .def("copy_to_host", &Memory::copy_to_host, "offset"_a, "bytes"_a, "stream"_a);
  module.def("device_release_memory", &cuda::release_device_memory);
  module.def("as_dlpack", as_dlpack, "memory"_a, "address"_a, "dtype"_a, "shape"_a, "device"_a);
}
