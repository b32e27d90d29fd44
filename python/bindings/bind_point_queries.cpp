#include <span>

#include <treelet/pipeline/bvh.h>

#include "arrays.h"
#include "bindings.h"
#include "host_rays.h"

namespace nb = nanobind;
using namespace nb::literals;

namespace {

treelet::PointBatch as_points(const Vec3Array& points) {
  return std::span(reinterpret_cast<const treelet::Vec3*>(points.data()), points.shape(0));
}

/// Points with a radius each, or one for all.
treelet::PointBatch as_spheres(std::size_t count, const Vec3Array& points,
                               const FloatArray& radii) {
  treelet::PointBatch batch;
  batch.size = count;
  batch.points = per_ray<treelet::Vec3>(points, count);
  batch.radii = per_ray<float>(radii, count);
  return batch;
}

nb::tuple closest_point(const treelet::Bvh& bvh, std::size_t count, const Vec3Array& points,
                        const FloatArray& max_distance, nb::handle given) {
  const treelet::PointBatch batch = as_spheres(count, points, max_distance);
  Answers<float> point(3 * count, part_of(given, 0)), distance(count, part_of(given, 1));
  Answers<std::int32_t> face(count, part_of(given, 2));
  Answers<float> u(count, part_of(given, 3)), v(count, part_of(given, 4));
  {
    const nb::gil_scoped_release release;
    bvh.closest_point(batch, {reinterpret_cast<treelet::Vec3*>(point.data()), distance.data(),
                              face.data(), u.data(), v.data()});
  }
  return nb::make_tuple(point.to_numpy(), distance.to_numpy(), face.to_numpy(), u.to_numpy(),
                        v.to_numpy());
}

/// An answer a point, which find(points, answers) writes.
template <class T, class Find>
NumpyArray<T> answer_points(const Vec3Array& points, nb::handle given, const Find& find) {
  const treelet::PointBatch batch = as_points(points);
  Answers<T> answers(batch.size, given);
  {
    const nb::gil_scoped_release release;
    find(batch, answers.span());
  }
  return answers.to_numpy();
}

NumpyArray<float> distance(const treelet::Bvh& bvh, const Vec3Array& points, nb::handle given) {
  return answer_points<float>(points, given, [&](const auto& batch, std::span<float> answers) {
    bvh.closest_point(batch, {.distance = answers.data()});
  });
}

NumpyArray<float> signed_distance(const treelet::Bvh& bvh, const Vec3Array& points,
                                  nb::handle given) {
  return answer_points<float>(points, given, [&](const auto& batch, std::span<float> answers) {
    bvh.signed_distance(batch, answers);
  });
}

NumpyArray<bool> contains(const treelet::Bvh& bvh, const Vec3Array& points, nb::handle given) {
  return answer_points<bool>(points, given, [&](const auto& batch, std::span<bool> answers) {
    bvh.contains(batch, answers);
  });
}

NumpyArray<float> winding_number(const treelet::Bvh& bvh, const Vec3Array& points, float accuracy,
                                 nb::handle given) {
  return answer_points<float>(points, given, [&](const auto& batch, std::span<float> answers) {
    bvh.winding_number(batch, accuracy, answers);
  });
}

nb::tuple to_python(treelet::Overlaps&& overlaps) {
  return nb::make_tuple(as_numpy(std::move(overlaps.offsets)), as_numpy(std::move(overlaps.face)));
}

nb::tuple overlap_boxes(const treelet::Bvh& bvh, std::size_t count, const Vec3Array& lower,
                        const Vec3Array& upper) {
  const treelet::BoxBatch boxes{count, per_ray<treelet::Vec3>(lower, count),
                                per_ray<treelet::Vec3>(upper, count)};
  treelet::Overlaps overlaps;
  {
    const nb::gil_scoped_release release;
    overlaps = bvh.overlap_boxes(boxes);
  }
  return to_python(std::move(overlaps));
}

nb::tuple overlap_spheres(const treelet::Bvh& bvh, std::size_t count, const Vec3Array& centers,
                          const FloatArray& radii) {
  const treelet::PointBatch spheres = as_spheres(count, centers, radii);
  treelet::Overlaps overlaps;
  {
    const nb::gil_scoped_release release;
    overlaps = bvh.overlap_spheres(spheres);
  }
  return to_python(std::move(overlaps));
}

}  // namespace

void bind_point_queries(nb::module_& module) {
  module.def("closest_point", closest_point, "bvh"_a, "count"_a, "points"_a.noconvert(),
             "max_distance"_a.noconvert(), "out"_a.none() = nb::none());
  module.def("distance", distance, "bvh"_a, "points"_a.noconvert(), "out"_a.none() = nb::none());
  module.def("signed_distance", signed_distance, "bvh"_a, "points"_a.noconvert(),
             "out"_a.none() = nb::none());
  module.def("contains", contains, "bvh"_a, "points"_a.noconvert(), "out"_a.none() = nb::none());
  module.def("winding_number", winding_number, "bvh"_a, "points"_a.noconvert(), "accuracy"_a,
             "out"_a.none() = nb::none());
  module.def("overlap_boxes", overlap_boxes, "bvh"_a, "count"_a, "lower"_a.noconvert(),
             "upper"_a.noconvert());
  module.def("overlap_spheres", overlap_spheres, "bvh"_a, "count"_a, "centers"_a.noconvert(),
             "radii"_a.noconvert());
}
