#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>

#include <treelet/query/intersect.h>
#include <treelet/query/ray_order.h>

#include "arrays.h"

// Rays in numpy arrays, and answers that become such.

/// One value for all rays where the array has a single one.
template <class T, class NdArray>
treelet::PerRay<T> per_ray(const NdArray& array, std::size_t rays) {
  const std::size_t size = array.shape(0);
  if (size != 1 && size != rays) throw nanobind::value_error("arrays of different numbers of rays");
  return {reinterpret_cast<const T*>(array.data()), size == 1 ? 0 : sizeof(T)};
}

inline treelet::RayBatch as_batch(std::size_t rays, const Vec3Array& origins,
                                  const Vec3Array& directions, const FloatArray& t_min,
                                  const FloatArray& t_max) {
  treelet::RayBatch batch;
  batch.size = rays;
  batch.origins = per_ray<treelet::Vec3>(origins, rays);
  batch.directions = per_ray<treelet::Vec3>(directions, rays);
  batch.t_min = per_ray<float>(t_min, rays);
  batch.t_max = per_ray<float>(t_max, rays);
  return batch;
}

inline treelet::RayOrder as_order(bool reorder) {
  return reorder ? treelet::RayOrder::coherent : treelet::RayOrder::given;
}

/// Four arrays that become t, face, u, v.
struct HostHits {
  treelet::Array<float> t;
  treelet::Array<std::int32_t> face;
  treelet::Array<float> u, v;

  explicit HostHits(std::size_t size) : t(size), face(size), u(size), v(size) {}
  treelet::HitArrays arrays() { return {t.data(), face.data(), u.data(), v.data()}; }
  nanobind::tuple to_python() {
    return nanobind::make_tuple(as_numpy(std::move(t)), as_numpy(std::move(face)),
                                as_numpy(std::move(u)), as_numpy(std::move(v)));
  }
};
