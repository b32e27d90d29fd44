#include <cstdint>

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <treelet/pipeline/device_bvh.h>

#include "arrays.h"
#include "device_address.h"
#include "device_arguments.h"
#include "host_rays.h"

namespace nb = nanobind;
namespace cuda = treelet::cuda;

namespace {

void count_hits(const cuda::DeviceBvh& bvh, const RayArguments& rays, Address counts,
                Address stream, bool reorder) {
  const nb::gil_scoped_release release;
  bvh.count_hits(rays.batch(bvh.device()), pointer<std::int64_t>(counts), stream_of(stream),
                 as_order(reorder));
}

std::size_t offset_hits(const cuda::DeviceBvh& bvh, const RayArguments& rays, Address offsets,
                        std::uint32_t limit, Address stream, bool reorder) {
  const nb::gil_scoped_release release;
  return bvh.offset_hits(rays.batch(bvh.device()), limit, pointer<std::int64_t>(offsets),
                         stream_of(stream), as_order(reorder));
}

void list_hits(const cuda::DeviceBvh& bvh, const RayArguments& rays, Address offsets, Address t,
               Address face, Address u, Address v, Address stream, bool reorder) {
  const nb::gil_scoped_release release;
  bvh.list_hits(
      rays.batch(bvh.device()), pointer<const std::int64_t>(offsets),
      {pointer<float>(t), pointer<std::int32_t>(face), pointer<float>(u), pointer<float>(v)},
      stream_of(stream), as_order(reorder));
}

NumpyArray<std::int64_t> stream_count_hits(const cuda::DeviceBvh& bvh, std::size_t rays,
                                           const Vec3Array& origins, const Vec3Array& directions,
                                           const FloatArray& t_min, const FloatArray& t_max,
                                           std::uint32_t limit, bool reorder,
                                           std::size_t device_bytes) {
  const treelet::RayBatch batch = as_batch(rays, origins, directions, t_min, t_max);
  treelet::Array<std::int64_t> counts(rays);
  {
    const nb::gil_scoped_release release;
    bvh.count_hits(batch, limit, counts.data(), {as_order(reorder), device_bytes});
  }
  return as_numpy(std::move(counts));
}

}  // namespace

void bind_device_hit_lists(nb::class_<cuda::DeviceBvh>& tree) {
  tree.def("count_hits", count_hits)
      .def("offset_hits", offset_hits)
      .def("list_hits", list_hits)
      .def("stream_count_hits", stream_count_hits);
}
