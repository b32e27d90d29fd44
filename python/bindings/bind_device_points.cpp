#include <cstdint>

#include <nanobind/nanobind.h>

#include <treelet/pipeline/device_bvh.h>

#include "device_address.h"
#include "device_arguments.h"

namespace nb = nanobind;
namespace cuda = treelet::cuda;

namespace {

/// Addresses of answers that are not wanted are zero.
void closest_point(const cuda::DeviceBvh& bvh, const PointArguments& points, Address point,
                   Address distance, Address face, Address u, Address v, Address stream) {
  const nb::gil_scoped_release release;
  bvh.closest_point(points.batch(bvh.device()),
                    {pointer<treelet::Vec3>(point), pointer<float>(distance),
                     pointer<std::int32_t>(face), pointer<float>(u), pointer<float>(v)},
                    stream_of(stream));
}

void contains(const cuda::DeviceBvh& bvh, const PointArguments& points, Address inside,
              Address stream) {
  const nb::gil_scoped_release release;
  bvh.contains(points.batch(bvh.device()), pointer<bool>(inside), stream_of(stream));
}

void signed_distance(const cuda::DeviceBvh& bvh, const PointArguments& points, Address distance,
                     Address stream) {
  const nb::gil_scoped_release release;
  bvh.signed_distance(points.batch(bvh.device()), pointer<float>(distance), stream_of(stream));
}

}  // namespace

void bind_device_points(nb::module_& module, nb::class_<cuda::DeviceBvh>& tree) {
  nb::class_<PointArguments>(module, "DevicePoints")
      .def(nb::init<std::size_t, Address, Address, std::size_t, std::size_t, float>());
  tree.def("closest_point", closest_point)
      .def("contains", contains)
      .def("signed_distance", signed_distance);
}
