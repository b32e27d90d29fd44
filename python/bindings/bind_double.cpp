#include <cmath>
#include <limits>
#include <string>

#include <nanobind/stl/string.h>

#include <treelet/core/parallel.h>
#include <treelet/pipeline/double_bvh.h>

#include "arrays.h"
#include "bindings.h"
#include "host_rays.h"
#include "report.h"

namespace nb = nanobind;
using namespace nb::literals;
using treelet::Array;

namespace {

using PointArray = nb::ndarray<const double, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using DoubleArray = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

constexpr std::size_t kGrain = 1 << 14;

treelet::DoubleRayBatch as_double_batch(std::size_t rays, const PointArray& origins,
                                        const PointArray& directions, const DoubleArray& t_min,
                                        const DoubleArray& t_max) {
  treelet::DoubleRayBatch batch;
  batch.size = rays;
  batch.origins = per_ray<treelet::DoubleVec3>(origins, rays);
  batch.directions = per_ray<treelet::DoubleVec3>(directions, rays);
  batch.t_min = per_ray<double>(t_min, rays);
  batch.t_max = per_ray<double>(t_max, rays);
  return batch;
}

treelet::DoubleBvh build(const PointArray& vertices, const FaceArray& faces,
                         const std::string& recipe, bool validate) {
  const treelet::DoubleMesh mesh{
      {reinterpret_cast<const treelet::DoubleVec3*>(vertices.data()), vertices.shape(0)},
      {reinterpret_cast<const treelet::Face*>(faces.data()), faces.shape(0)}};
  treelet::BuildOptions options;
  options.validate |= validate;
  const nb::gil_scoped_release release;
  return treelet::build(mesh, recipe, options);
}

nb::tuple bounds(const treelet::DoubleBvh& bvh) {
  const treelet::BoxFrame& frame = bvh.layout.frame;
  constexpr double inf = std::numeric_limits<double>::infinity();
  if (frame.is_empty) {
    return nb::make_tuple(nb::make_tuple(inf, inf, inf), nb::make_tuple(-inf, -inf, -inf));
  }
  const auto corner = [](const treelet::DoubleVec3& p) { return nb::make_tuple(p.x, p.y, p.z); };
  return nb::make_tuple(corner(frame.lower), corner(frame.upper));
}

nb::tuple intersect(const treelet::DoubleBvh& bvh, std::size_t rays, const PointArray& origins,
                    const PointArray& directions, const DoubleArray& t_min,
                    const DoubleArray& t_max) {
  const treelet::DoubleRayBatch batch = as_double_batch(rays, origins, directions, t_min, t_max);
  Array<double> t(rays), u(rays), v(rays);
  Array<std::int32_t> face(rays);
  {
    const nb::gil_scoped_release release;
    Array<treelet::DoubleHit> hits(rays);
    treelet::intersect(bvh.layout, batch, hits);
    treelet::parallel_for(rays, kGrain, [&](std::size_t i) {
      t[i] = hits[i].t;
      face[i] = hits[i].face;
      u[i] = hits[i].u;
      v[i] = hits[i].v;
    });
  }
  return nb::make_tuple(as_numpy(std::move(t)), as_numpy(std::move(face)), as_numpy(std::move(u)),
                        as_numpy(std::move(v)));
}

NumpyArray<bool> occluded(const treelet::DoubleBvh& bvh, std::size_t rays,
                          const PointArray& origins, const PointArray& directions,
                          const DoubleArray& t_min, const DoubleArray& t_max) {
  const treelet::DoubleRayBatch batch = as_double_batch(rays, origins, directions, t_min, t_max);
  Array<bool> found(rays);
  {
    const nb::gil_scoped_release release;
    treelet::find_occluded(bvh.layout, batch, found);
  }
  return as_numpy(std::move(found));
}

NumpyArray<std::int64_t> count_hits(const treelet::DoubleBvh& bvh, std::size_t rays,
                                    const PointArray& origins, const PointArray& directions,
                                    const DoubleArray& t_min, const DoubleArray& t_max) {
  const treelet::DoubleRayBatch batch = as_double_batch(rays, origins, directions, t_min, t_max);
  Array<std::int64_t> counts(rays);
  {
    const nb::gil_scoped_release release;
    treelet::count_hits(bvh.layout, batch, counts);
  }
  return as_numpy(std::move(counts));
}

nb::tuple intersect_all(const treelet::DoubleBvh& bvh, std::size_t rays, const PointArray& origins,
                        const PointArray& directions, const DoubleArray& t_min,
                        const DoubleArray& t_max, std::size_t limit) {
  const treelet::DoubleRayBatch batch = as_double_batch(rays, origins, directions, t_min, t_max);
  treelet::DoubleAllHits hits;
  {
    const nb::gil_scoped_release release;
    hits = treelet::intersect_all(bvh.layout, batch, limit);
  }
  return nb::make_tuple(as_numpy(std::move(hits.offsets)), as_numpy(std::move(hits.t)),
                        as_numpy(std::move(hits.face)), as_numpy(std::move(hits.u)),
                        as_numpy(std::move(hits.v)));
}

}  // namespace

void bind_double(nb::module_& module) {
  nb::class_<treelet::DoubleBvh>(module, "DoubleBvh")
      .def_prop_ro("report",
                   [](const treelet::DoubleBvh& bvh) { return describe_report(bvh.report); })
      .def_prop_ro("bounds", bounds)
      .def(
          "epo", [](const treelet::DoubleBvh&, std::size_t) { return std::nan(""); },
          "max_triangles"_a)
      .def("intersect", intersect, "rays"_a, "origins"_a.noconvert(), "directions"_a.noconvert(),
           "t_min"_a.noconvert(), "t_max"_a.noconvert())
      .def("occluded", occluded, "rays"_a, "origins"_a.noconvert(), "directions"_a.noconvert(),
           "t_min"_a.noconvert(), "t_max"_a.noconvert())
      .def("count_hits", count_hits, "rays"_a, "origins"_a.noconvert(), "directions"_a.noconvert(),
           "t_min"_a.noconvert(), "t_max"_a.noconvert())
      .def("intersect_all", intersect_all, "rays"_a, "origins"_a.noconvert(),
           "directions"_a.noconvert(), "t_min"_a.noconvert(), "t_max"_a.noconvert(), "limit"_a);
  module.def("build_double", build, "vertices"_a.noconvert(), "faces"_a.noconvert(), "recipe"_a,
             "validate"_a);
}
