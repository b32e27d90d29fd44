#include <nanobind/stl/string.h>

#include <treelet/core/cuda_device.h>

#include "bindings.h"

namespace nb = nanobind;

namespace {

/// (name, (major, minor), bytes, multiprocessors) of each device.
nb::list describe_devices() {
  nb::list result;
  for (const treelet::cuda::DeviceInfo& device : treelet::cuda::devices()) {
    result.append(nb::make_tuple(device.name,
                                 nb::make_tuple(device.capability_major, device.capability_minor),
                                 device.bytes, device.multiprocessors));
  }
  return result;
}

}  // namespace

void bind_cuda(nb::module_& module) {
  module.def("cuda_is_compiled_in", &treelet::cuda::is_compiled_in,
             "Whether the library holds CUDA code.");
  module.def("cuda_is_available", &treelet::cuda::is_available,
             nb::call_guard<nb::gil_scoped_release>(), "Whether there is a GPU to use.");
  module.def("cuda_why_unavailable", &treelet::cuda::why_unavailable,
             nb::call_guard<nb::gil_scoped_release>(), "What is missing; empty if nothing.");
  module.def("cuda_devices", &describe_devices,
             "(name, compute capability, bytes, multiprocessors) of each GPU.");
}
