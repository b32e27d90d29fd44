#include <cstdint>
#include <stdexcept>
#include <string>

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>

#include <treelet/core/device_array.h>
#include <treelet/core/device_scope.h>
#include <treelet/mesh/narrow_faces.h>
#include <treelet/pipeline/device_bvh.h>

#include "arrays.h"
#include "bindings.h"
#include "device_address.h"
#include "device_arguments.h"
#include "host_rays.h"
#include "report.h"

namespace nb = nanobind;
namespace cuda = treelet::cuda;
using namespace nb::literals;

namespace {

/// Faces as they come: indices of 4 bytes are used in place, those of 8 copied.
class Faces {
 public:
  Faces(Address address, std::size_t count, int index_bytes, cuda::Stream stream) {
    if (index_bytes == 8) {
      narrowed_ = cuda::narrow_faces(pointer<const std::int64_t>(address), count, stream);
      data_ = narrowed_.data();
    } else {
      data_ = pointer<const treelet::Face>(address);
    }
  }
  const treelet::Face* data() const { return data_; }

 private:
  cuda::DeviceArray<treelet::Face> narrowed_;
  const treelet::Face* data_;
};

cuda::DeviceBvh build(Address vertices, std::size_t vertex_count, Address faces,
                      std::size_t face_count, int index_bytes, const std::string& recipe,
                      bool validate, bool updatable, Address stream) {
  const nb::gil_scoped_release release;
  const treelet::Recipe parsed = treelet::parse_recipe(recipe);
  treelet::check_face_count(face_count);
  if (vertex_count > 0xffffffff) {
    throw std::invalid_argument("the mesh has " + std::to_string(vertex_count) +
                                " vertices; indices have 32 bits");
  }
  const cuda::DeviceScope scope(vertex_count > 0 ? device_of(vertices, "vertices")
                                                 : cuda::current_device());
  if (face_count > 0) require_device(faces, cuda::current_device(), "faces");
  const Faces indices(faces, face_count, index_bytes, stream_of(stream));
  const cuda::DeviceMesh mesh{pointer<const treelet::Vec3>(vertices), indices.data(),
                              std::uint32_t(vertex_count), std::uint32_t(face_count)};
  return cuda::DeviceBvh::build(mesh, parsed, {validate, updatable}, stream_of(stream));
}

void intersect(const cuda::DeviceBvh& bvh, const RayArguments& rays, Address t, Address face,
               Address u, Address v, Address stream, bool reorder) {
  const nb::gil_scoped_release release;
  bvh.intersect(
      rays.batch(bvh.device()),
      {pointer<float>(t), pointer<std::int32_t>(face), pointer<float>(u), pointer<float>(v)},
      stream_of(stream), as_order(reorder));
}

void occluded(const cuda::DeviceBvh& bvh, const RayArguments& rays, Address result, Address stream,
              bool reorder) {
  const nb::gil_scoped_release release;
  bvh.find_occluded(rays.batch(bvh.device()), pointer<bool>(result), stream_of(stream),
                    as_order(reorder));
}

void traversal_cost(const cuda::DeviceBvh& bvh, const RayArguments& rays, Address nodes,
                    Address triangles, Address stream, bool reorder) {
  const nb::gil_scoped_release release;
  bvh.count_work(rays.batch(bvh.device()),
                 {pointer<std::uint32_t>(nodes), pointer<std::uint32_t>(triangles)},
                 stream_of(stream), as_order(reorder));
}

nb::tuple stream_intersect(const cuda::DeviceBvh& bvh, std::size_t rays, const Vec3Array& origins,
                           const Vec3Array& directions, const FloatArray& t_min,
                           const FloatArray& t_max, bool reorder, std::size_t device_bytes) {
  const treelet::RayBatch batch = as_batch(rays, origins, directions, t_min, t_max);
  HostHits hits(rays);
  {
    const nb::gil_scoped_release release;
    bvh.intersect(batch, hits.arrays(), {as_order(reorder), device_bytes});
  }
  return hits.to_python();
}

nb::tuple stream_occluded(const cuda::DeviceBvh& bvh, std::size_t rays, const Vec3Array& origins,
                          const Vec3Array& directions, const FloatArray& t_min,
                          const FloatArray& t_max, bool reorder, std::size_t device_bytes) {
  const treelet::RayBatch batch = as_batch(rays, origins, directions, t_min, t_max);
  treelet::Array<bool> occluded(rays);
  {
    const nb::gil_scoped_release release;
    bvh.find_occluded(batch, occluded.data(), {as_order(reorder), device_bytes});
  }
  return nb::make_tuple(as_numpy(std::move(occluded)));
}

nb::tuple stream_traversal_cost(const cuda::DeviceBvh& bvh, std::size_t rays,
                                const Vec3Array& origins, const Vec3Array& directions,
                                const FloatArray& t_min, const FloatArray& t_max, bool reorder,
                                std::size_t device_bytes) {
  const treelet::RayBatch batch = as_batch(rays, origins, directions, t_min, t_max);
  treelet::Array<std::uint32_t> nodes(rays), triangles(rays);
  {
    const nb::gil_scoped_release release;
    bvh.count_work(batch, {nodes.data(), triangles.data()}, {as_order(reorder), device_bytes});
  }
  return nb::make_tuple(as_numpy(std::move(nodes)), as_numpy(std::move(triangles)));
}

nb::object bounds(const cuda::DeviceBvh& bvh) {
  const treelet::Aabb box = bvh.bounds();
  return nb::make_tuple(nb::make_tuple(box.lower.x, box.lower.y, box.lower.z),
                        nb::make_tuple(box.upper.x, box.upper.y, box.upper.z));
}

void bind_tree(nb::module_& module) {
  nb::class_<cuda::DeviceBvh> tree(module, "DeviceBvh");
  tree.def_prop_ro("report",
                   [](const cuda::DeviceBvh& bvh) { return describe_report(bvh.report()); })
      .def_prop_ro("bounds", bounds)
      .def_prop_ro("device", &cuda::DeviceBvh::device)
      .def("epo", &cuda::DeviceBvh::epo, "max_triangles"_a)
      .def("refit",
           [](cuda::DeviceBvh& bvh, Address vertices, std::uint32_t count, Address stream) {
             const nb::gil_scoped_release release;
             if (count > 0) require_device(vertices, bvh.device(), "vertices");
             bvh.refit(pointer<const treelet::Vec3>(vertices), count, stream_of(stream));
           })
      .def("rebuild",
           [](cuda::DeviceBvh& bvh, Address vertices, std::uint32_t count, Address stream) {
             const nb::gil_scoped_release release;
             if (count > 0) require_device(vertices, bvh.device(), "vertices");
             bvh.rebuild(pointer<const treelet::Vec3>(vertices), count, stream_of(stream));
           })
      .def("check",
           [](cuda::DeviceBvh& bvh, Address stream) {
             const nb::gil_scoped_release release;
             bvh.check(stream_of(stream));
           })
      .def("download", [](const cuda::DeviceBvh& bvh,
                          Address stream) { return bvh.download(stream_of(stream)); })
      .def("intersect", intersect)
      .def("occluded", occluded)
      .def("traversal_cost", traversal_cost)
      .def("stream_intersect", stream_intersect)
      .def("stream_occluded", stream_occluded)
      .def("stream_traversal_cost", stream_traversal_cost);
  bind_device_hit_lists(tree);
  bind_device_points(module, tree);
}

}  // namespace

void bind_device(nb::module_& module) {
  nb::class_<RayArguments>(module, "DeviceRays")
      .def(nb::init<std::size_t, Address, Address, Address, Address, std::size_t, std::size_t,
                    std::size_t, std::size_t, float, float>());
  bind_tree(module);
  module.def("device_build", build);
  module.def("device_upload", [](const treelet::Bvh& bvh, Address stream) {
    const nb::gil_scoped_release release;
    return cuda::DeviceBvh::upload(bvh, stream_of(stream));
  });
  module.def("device_current", &cuda::current_device);
  module.def("device_of", device_of, "address"_a, "what"_a);
  module.def(
      "device_synchronize",
      [](Address stream, int device) {
        const nb::gil_scoped_release release;
        const cuda::DeviceScope scope(device < 0 ? cuda::current_device() : device);
        cuda::synchronize(stream_of(stream));
      },
      "stream"_a, "device"_a = -1);
}
