#include <algorithm>
#include <array>

#include <treelet/core/parallel.h>
#include <treelet/pipeline/bvh.h>
#include <treelet/query/brute_force.h>

#include "arrays.h"
#include "bindings.h"

namespace nb = nanobind;
using namespace nb::literals;
using treelet::Array;

namespace {

/// One value for all rays where the array has a single one.
template <class T, class NdArray>
treelet::PerRay<T> per_ray(const NdArray& array, std::size_t rays) {
  const std::size_t size = array.shape(0);
  if (size != 1 && size != rays) throw nb::value_error("arrays of different numbers of rays");
  return {reinterpret_cast<const T*>(array.data()), size == 1 ? 0 : sizeof(T)};
}

treelet::RayBatch as_batch(std::size_t rays, const Vec3Array& origins, const Vec3Array& directions,
                           const FloatArray& t_min, const FloatArray& t_max) {
  treelet::RayBatch batch;
  batch.size = rays;
  batch.origins = per_ray<treelet::Vec3>(origins, rays);
  batch.directions = per_ray<treelet::Vec3>(directions, rays);
  batch.t_min = per_ray<float>(t_min, rays);
  batch.t_max = per_ray<float>(t_max, rays);
  return batch;
}

/// Four arrays that become t, face, u, v.
struct Hits {
  Array<float> t;
  Array<std::int32_t> face;
  Array<float> u, v;

  explicit Hits(std::size_t size) : t(size), face(size), u(size), v(size) {}
  treelet::HitArrays arrays() { return {t.data(), face.data(), u.data(), v.data()}; }
  nb::tuple to_python() {
    return nb::make_tuple(as_numpy(std::move(t)), as_numpy(std::move(face)), as_numpy(std::move(u)),
                          as_numpy(std::move(v)));
  }
};

nb::tuple intersect(const treelet::Bvh& bvh, std::size_t rays, const Vec3Array& origins,
                    const Vec3Array& directions, const FloatArray& t_min, const FloatArray& t_max) {
  const treelet::RayBatch batch = as_batch(rays, origins, directions, t_min, t_max);
  Hits hits(rays);
  {
    const nb::gil_scoped_release release;
    bvh.intersect(batch, hits.arrays());
  }
  return hits.to_python();
}

NumpyArray<bool> occluded(const treelet::Bvh& bvh, std::size_t rays, const Vec3Array& origins,
                          const Vec3Array& directions, const FloatArray& t_min,
                          const FloatArray& t_max) {
  const treelet::RayBatch batch = as_batch(rays, origins, directions, t_min, t_max);
  Array<bool> occluded(rays);
  {
    const nb::gil_scoped_release release;
    bvh.find_occluded(batch, occluded);
  }
  return as_numpy(std::move(occluded));
}

nb::tuple traversal_cost(const treelet::Bvh& bvh, std::size_t rays, const Vec3Array& origins,
                         const Vec3Array& directions, const FloatArray& t_min,
                         const FloatArray& t_max) {
  const treelet::RayBatch batch = as_batch(rays, origins, directions, t_min, t_max);
  Array<std::uint32_t> nodes(rays), triangles(rays);
  {
    const nb::gil_scoped_release release;
    Array<treelet::Work> work(rays);
    bvh.count_work(batch, work);
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
  Hits hits(rays);
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
  // Methods of Bvh, as functions: the class belongs to the pipeline.
  module.def("intersect", intersect, "bvh"_a, "rays"_a, "origins"_a.noconvert(),
             "directions"_a.noconvert(), "t_min"_a.noconvert(), "t_max"_a.noconvert());
  module.def("occluded", occluded, "bvh"_a, "rays"_a, "origins"_a.noconvert(),
             "directions"_a.noconvert(), "t_min"_a.noconvert(), "t_max"_a.noconvert());
  module.def("traversal_cost", traversal_cost, "bvh"_a, "rays"_a, "origins"_a.noconvert(),
             "directions"_a.noconvert(), "t_min"_a.noconvert(), "t_max"_a.noconvert());
  module.def("intersect_brute_force", intersect_brute_force, "vertices"_a.noconvert(),
             "faces"_a.noconvert(), "rays"_a, "origins"_a.noconvert(), "directions"_a.noconvert(),
             "t_min"_a.noconvert(), "t_max"_a.noconvert());
}
