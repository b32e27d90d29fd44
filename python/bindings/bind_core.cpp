#include <treelet/core/parallel.h>

#include "bindings.h"

namespace nb = nanobind;
using namespace nb::literals;

void bind_core(nb::module_& module) {
  module.def("thread_count", &treelet::thread_count,
             "Threads that builds and batches use, the caller's included.");
  module.def("set_thread_count", &treelet::set_thread_count, "count"_a,
             nb::call_guard<nb::gil_scoped_release>(),
             "Set the number of threads; 0 means one a hardware thread.");
}
