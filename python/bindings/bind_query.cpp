#include <span>

#include <nanobind/stl/optional.h>

#include <treelet/core/parallel.h>
#include <treelet/pipeline/bvh.h>
#include <treelet/query/brute_force.h>

#include "arrays.h"
#include "bindings.h"
#include "host_rays.h"

namespace nb = nanobind;
using namespace nb::literals;
using treelet::Array;

namespace {

nb::tuple intersect(const treelet::Bvh& bvh, std::size_t rays, const Vec3Array& origins,
                    const Vec3Array& directions, const FloatArray& t_min, const FloatArray& t_max,
                    bool reorder, std::size_t row, const RayFilter* filter, nb::handle given) {
  treelet::RayBatch batch = as_batch(rays, origins, directions, t_min, t_max, filter);
  batch.row = row;
  HostHits hits(rays, given);
  {
    const nb::gil_scoped_release release;
    const treelet::HitArrays out = hits.arrays();
    treelet::trace_in_order(as_order(reorder), bvh.bounds(), batch,
                            [&](const treelet::RayBatch& part, std::size_t first) {
                              bvh.intersect(part, out.from(first));
                            });
  }
  return hits.to_python();
}

NumpyArray<bool> occluded(const treelet::Bvh& bvh, std::size_t rays, const Vec3Array& origins,
                          const Vec3Array& directions, const FloatArray& t_min,
                          const FloatArray& t_max, bool reorder, std::size_t row,
                          const RayFilter* filter, nb::handle given) {
  treelet::RayBatch batch = as_batch(rays, origins, directions, t_min, t_max, filter);
  batch.row = row;
  Answers<bool> occluded(rays, given);
  {
    const nb::gil_scoped_release release;
    const std::span<bool> out = occluded.span();
    treelet::trace_in_order(as_order(reorder), bvh.bounds(), batch,
                            [&](const treelet::RayBatch& part, std::size_t first) {
                              bvh.find_occluded(part, out.subspan(first, part.size));
                            });
  }
  return occluded.to_numpy();
}

nb::tuple traversal_cost(const treelet::Bvh& bvh, std::size_t rays, const Vec3Array& origins,
                         const Vec3Array& directions, const FloatArray& t_min,
                         const FloatArray& t_max, bool reorder, const RayFilter* filter) {
  const treelet::RayBatch batch = as_batch(rays, origins, directions, t_min, t_max, filter);
  Array<std::uint32_t> nodes(rays), triangles(rays);
  {
    const nb::gil_scoped_release release;
    Array<treelet::Work> work(rays);
    const std::span<treelet::Work> out = work;
    treelet::trace_in_order(as_order(reorder), bvh.bounds(), batch,
                            [&](const treelet::RayBatch& part, std::size_t first) {
                              bvh.count_work(part, out.subspan(first, part.size));
                            });
    for (std::size_t i = 0; i < rays; ++i) {
      nodes[i] = work[i].nodes;
      triangles[i] = work[i].triangles;
    }
  }
  return nb::make_tuple(as_numpy(std::move(nodes)), as_numpy(std::move(triangles)));
}

nb::tuple intersect_brute_force(const Vec3Array& vertices, const FaceArray& faces, std::size_t rays,
                                const Vec3Array& origins, const Vec3Array& directions,
                                const FloatArray& t_min, const FloatArray& t_max) {
  const treelet::Mesh mesh = as_mesh(vertices, faces);
  const treelet::RayBatch batch = as_batch(rays, origins, directions, t_min, t_max);
  HostHits hits(rays);
  {
    const nb::gil_scoped_release release;
    treelet::check_indices(mesh);
    const treelet::HitArrays out = hits.arrays();
    treelet::parallel_for(rays, 1, [&](std::size_t i) {
      out.set(i, treelet::intersect_brute_force(mesh, batch[i]));
    });
  }
  return hits.to_python();
}

}  // namespace

void bind_query(nb::module_& module) {
  nb::class_<RayFilter>(module, "RayFilter")
      .def(nb::init<std::optional<FlagArray>, std::optional<FlagArray>, std::uint8_t>(),
           "active"_a.none(), "face_mask"_a.none(), "cull"_a);
  // Methods of Bvh, as functions: the class belongs to the pipeline.
  module.def("intersect", intersect, "bvh"_a, "rays"_a, "origins"_a.noconvert(),
             "directions"_a.noconvert(), "t_min"_a.noconvert(), "t_max"_a.noconvert(), "reorder"_a,
             "row"_a, "filter"_a.none() = nb::none(), "out"_a.none() = nb::none());
  module.def("occluded", occluded, "bvh"_a, "rays"_a, "origins"_a.noconvert(),
             "directions"_a.noconvert(), "t_min"_a.noconvert(), "t_max"_a.noconvert(), "reorder"_a,
             "row"_a, "filter"_a.none() = nb::none(), "out"_a.none() = nb::none());
  module.def("traversal_cost", traversal_cost, "bvh"_a, "rays"_a, "origins"_a.noconvert(),
             "directions"_a.noconvert(), "t_min"_a.noconvert(), "t_max"_a.noconvert(), "reorder"_a,
             "filter"_a.none() = nb::none());
  module.def("intersect_brute_force", intersect_brute_force, "vertices"_a.noconvert(),
             "faces"_a.noconvert(), "rays"_a, "origins"_a.noconvert(), "directions"_a.noconvert(),
             "t_min"_a.noconvert(), "t_max"_a.noconvert());
}
