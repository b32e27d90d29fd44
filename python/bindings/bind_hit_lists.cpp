#include <treelet/pipeline/bvh.h>

#include "arrays.h"
#include "bindings.h"
#include "host_rays.h"

namespace nb = nanobind;
using namespace nb::literals;

namespace {

nb::tuple intersect_all(const treelet::Bvh& bvh, std::size_t rays, const Vec3Array& origins,
                        const Vec3Array& directions, const FloatArray& t_min,
                        const FloatArray& t_max, std::size_t limit, bool reorder,
                        const RayFilter* filter) {
  const treelet::RayBatch batch = as_batch(rays, origins, directions, t_min, t_max, filter);
  treelet::AllHits hits;
  {
    const nb::gil_scoped_release release;
    hits = bvh.intersect_all(batch, {.limit = limit, .order = as_order(reorder)});
  }
  return nb::make_tuple(as_numpy(std::move(hits.offsets)), as_numpy(std::move(hits.t)),
                        as_numpy(std::move(hits.face)), as_numpy(std::move(hits.u)),
                        as_numpy(std::move(hits.v)));
}

NumpyArray<std::int64_t> count_hits(const treelet::Bvh& bvh, std::size_t rays,
                                    const Vec3Array& origins, const Vec3Array& directions,
                                    const FloatArray& t_min, const FloatArray& t_max, bool reorder,
                                    const RayFilter* filter, nb::handle given) {
  const treelet::RayBatch batch = as_batch(rays, origins, directions, t_min, t_max, filter);
  Answers<std::int64_t> counts(rays, given);
  {
    const nb::gil_scoped_release release;
    const std::span<std::int64_t> out = counts.span();
    treelet::trace_in_order(as_order(reorder), bvh.bounds(), batch,
                            [&](const treelet::RayBatch& part, std::size_t first) {
                              bvh.count_hits(part, out.subspan(first, part.size));
                            });
  }
  return counts.to_numpy();
}

}  // namespace

void bind_hit_lists(nb::module_& module) {
  module.def("intersect_all", intersect_all, "bvh"_a, "rays"_a, "origins"_a.noconvert(),
             "directions"_a.noconvert(), "t_min"_a.noconvert(), "t_max"_a.noconvert(), "limit"_a,
             "reorder"_a, "filter"_a.none() = nb::none());
  module.def("count_hits", count_hits, "bvh"_a, "rays"_a, "origins"_a.noconvert(),
             "directions"_a.noconvert(), "t_min"_a.noconvert(), "t_max"_a.noconvert(), "reorder"_a,
             "filter"_a.none() = nb::none(), "out"_a.none() = nb::none());
}
