#include <span>

#include <treelet/pipeline/bvh.h>

#include "arrays.h"
#include "bindings.h"
#include "host_rays.h"

namespace nb = nanobind;
using namespace nb::literals;
using treelet::Array;

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

/// An array of three floats a point.
NumpyArray<float> as_numpy_vectors(Array<treelet::Vec3>&& array) {
  auto* kept = new Array<treelet::Vec3>(std::move(array));
  nb::capsule owner(kept, [](void* p) noexcept { delete static_cast<Array<treelet::Vec3>*>(p); });
  return NumpyArray<float>(kept->data(), {kept->size(), 3}, owner);
}

nb::tuple closest_point(const treelet::Bvh& bvh, std::size_t count, const Vec3Array& points,
                        const FloatArray& max_distance) {
  const treelet::PointBatch batch = as_spheres(count, points, max_distance);
  Array<treelet::Vec3> point(count);
  Array<float> distance(count), u(count), v(count);
  Array<std::int32_t> face(count);
  {
    const nb::gil_scoped_release release;
    bvh.closest_point(batch, {point.data(), distance.data(), face.data(), u.data(), v.data()});
  }
  return nb::make_tuple(as_numpy_vectors(std::move(point)), as_numpy(std::move(distance)),
                        as_numpy(std::move(face)), as_numpy(std::move(u)), as_numpy(std::move(v)));
}

/// An answer a point, which find(points, answers) writes.
template <class T, class Find>
NumpyArray<T> answer_points(const Vec3Array& points, const Find& find) {
  const treelet::PointBatch batch = as_points(points);
  Array<T> answers(batch.size);
  {
    const nb::gil_scoped_release release;
    find(batch, std::span<T>(answers));
  }
  return as_numpy(std::move(answers));
}

NumpyArray<float> distance(const treelet::Bvh& bvh, const Vec3Array& points) {
  return answer_points<float>(points, [&](const auto& batch, std::span<float> answers) {
    bvh.closest_point(batch, {.distance = answers.data()});
  });
}

NumpyArray<float> signed_distance(const treelet::Bvh& bvh, const Vec3Array& points) {
  return answer_points<float>(points, [&](const auto& batch, std::span<float> answers) {
    bvh.signed_distance(batch, answers);
  });
}

NumpyArray<bool> contains(const treelet::Bvh& bvh, const Vec3Array& points) {
  return answer_points<bool>(
      points, [&](const auto& batch, std::span<bool> answers) { bvh.contains(batch, answers); });
}

NumpyArray<float> winding_number(const treelet::Bvh& bvh, const Vec3Array& points, float accuracy) {
  return answer_points<float>(points, [&](const auto& batch, std::span<float> answers) {
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
             "max_distance"_a.noconvert());
  module.def("distance", distance, "bvh"_a, "points"_a.noconvert());
  module.def("signed_distance", signed_distance, "bvh"_a, "points"_a.noconvert());
  module.def("contains", contains, "bvh"_a, "points"_a.noconvert());
  module.def("winding_number", winding_number, "bvh"_a, "points"_a.noconvert(), "accuracy"_a);
  module.def("overlap_boxes", overlap_boxes, "bvh"_a, "count"_a, "lower"_a.noconvert(),
             "upper"_a.noconvert());
  module.def("overlap_spheres", overlap_spheres, "bvh"_a, "count"_a, "centers"_a.noconvert(),
             "radii"_a.noconvert());
}
