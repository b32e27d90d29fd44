#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
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

/// Which rays are traced, and which faces they can hit; keeps the arrays that a call reads.
struct RayFilter {
  std::optional<FlagArray> active, face_mask;
  treelet::Cull cull;

  /// `cull` by its number.
  RayFilter(std::optional<FlagArray> rays, std::optional<FlagArray> faces, std::uint8_t number)
      : active(std::move(rays)), face_mask(std::move(faces)), cull(treelet::Cull(number)) {}

  void apply(treelet::RayBatch& batch) const {
    if (active) batch.active = per_ray<bool>(*active, batch.size);
    batch.filter = {cull, face_mask ? face_mask->data() : nullptr};
  }
};

inline treelet::RayBatch as_batch(std::size_t rays, const Vec3Array& origins,
                                  const Vec3Array& directions, const FloatArray& t_min,
                                  const FloatArray& t_max, const RayFilter* filter) {
  treelet::RayBatch batch = as_batch(rays, origins, directions, t_min, t_max);
  if (filter != nullptr) filter->apply(batch);
  return batch;
}

inline treelet::RayOrder as_order(bool reorder) {
  return reorder ? treelet::RayOrder::coherent : treelet::RayOrder::given;
}

/// Four arrays that become t, face, u, v, or that the caller gave for them.
struct HostHits {
  Answers<float> t;
  Answers<std::int32_t> face;
  Answers<float> u, v;

  explicit HostHits(std::size_t size, nanobind::handle given = nanobind::none())
      : t(size, part_of(given, 0)),
        face(size, part_of(given, 1)),
        u(size, part_of(given, 2)),
        v(size, part_of(given, 3)) {}
  treelet::HitArrays arrays() { return {t.data(), face.data(), u.data(), v.data()}; }
  nanobind::tuple to_python() {
    return nanobind::make_tuple(t.to_numpy(), face.to_numpy(), u.to_numpy(), v.to_numpy());
  }
};
