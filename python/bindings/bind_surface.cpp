#include <nanobind/stl/optional.h>

#include <treelet/pipeline/bvh.h>

#include "arrays.h"
#include "bindings.h"
#include "host_rays.h"

namespace nb = nanobind;
using namespace nb::literals;

namespace {

std::span<const std::int32_t> as_span(const FaceNumbers& faces) {
  return {faces.data(), faces.shape(0)};
}

NumpyArray<float> triangles(const treelet::Bvh& bvh, const FaceNumbers& faces) {
  const std::span<const std::int32_t> of = as_span(faces);
  Answers<float> corners(9 * of.size());
  {
    const nb::gil_scoped_release release;
    bvh.find_triangles(of, {reinterpret_cast<treelet::Triangle*>(corners.data()), of.size()});
  }
  return corners.to_numpy();
}

NumpyArray<float> normals(const treelet::Bvh& bvh, const FaceNumbers& faces,
                          const std::optional<Vec3Array>& facing) {
  const std::span<const std::int32_t> of = as_span(faces);
  treelet::PerRay<treelet::Vec3> directions;
  if (facing) directions = per_ray<treelet::Vec3>(*facing, of.size());
  Answers<float> normals(3 * of.size());
  {
    const nb::gil_scoped_release release;
    bvh.find_normals(of, directions, {reinterpret_cast<treelet::Vec3*>(normals.data()), of.size()});
  }
  return normals.to_numpy();
}

NumpyArray<float> spawn(const treelet::Bvh& bvh, std::size_t rays, const FaceNumbers& face,
                        const FloatArray& u, const FloatArray& v, const Vec3Array& directions,
                        double far) {
  const treelet::SpawnBatch batch{rays,
                                  per_ray<std::int32_t>(face, rays),
                                  per_ray<float>(u, rays),
                                  per_ray<float>(v, rays),
                                  per_ray<treelet::Vec3>(directions, rays),
                                  far};
  Answers<float> origins(3 * rays);
  {
    const nb::gil_scoped_release release;
    bvh.spawn(batch, {reinterpret_cast<treelet::Vec3*>(origins.data()), rays});
  }
  return origins.to_numpy();
}

}  // namespace

void bind_surface(nb::module_& module) {
  module.def("triangles", triangles, "bvh"_a, "faces"_a.noconvert());
  module.def("normals", normals, "bvh"_a, "faces"_a.noconvert(),
             "facing"_a.noconvert().none() = nb::none());
  module.def("spawn", spawn, "bvh"_a, "rays"_a, "face"_a.noconvert(), "u"_a.noconvert(),
             "v"_a.noconvert(), "directions"_a.noconvert(), "far"_a);
}
