#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>

#include <nanobind/nanobind.h>

#include <treelet/core/device_scope.h>
#include <treelet/pipeline/device_bvh.h>

#include "device_address.h"

// Arrays in device memory as the arguments of queries, checked to lie where the tree does.

inline int device_of(Address address, const char* what) {
  return treelet::cuda::device_of(pointer<const void>(address), what);
}

inline void require_device(Address address, int device, const char* what) {
  const int actual = device_of(address, what);
  if (actual == device) return;
  throw std::invalid_argument(std::string(what) + " lie on device " + std::to_string(actual) +
                              ", the rest on device " + std::to_string(device) +
                              ": copy them there");
}

/// What the Python layer says of some rays: (address, rows) of origins and directions, and
/// (address, rows, value) of t_min and t_max; rows is 1 or the number of rays, address 0 means the
/// value.
struct RayArguments {
  std::size_t count;
  Address origins, directions, t_min, t_max;
  std::size_t origin_rows, direction_rows, t_min_rows, t_max_rows;
  float all_t_min, all_t_max;

  treelet::cuda::DeviceRayBatch batch(int device) const {
    if (count > 0) {
      require_device(origins, device, "origins");
      require_device(directions, device, "directions");
      if (t_min != 0) require_device(t_min, device, "t_min");
      if (t_max != 0) require_device(t_max, device, "t_max");
    }
    return {.size = count,
            .origins = rows<treelet::Vec3>(origins, origin_rows),
            .directions = rows<treelet::Vec3>(directions, direction_rows),
            .t_min = rows<float>(t_min, t_min_rows),
            .t_max = rows<float>(t_max, t_max_rows),
            .all_t_min = all_t_min,
            .all_t_max = all_t_max};
  }

 private:
  template <class T>
  treelet::PerRay<T> rows(Address address, std::size_t row_count) const {
    return {pointer<const T>(address), row_count == count ? sizeof(T) : 0};
  }
};

/// What the Python layer says of some points, in the same way; radii as t_min.
struct PointArguments {
  std::size_t count;
  Address points, radii;
  std::size_t point_rows, radius_rows;
  float all_radii;

  treelet::cuda::DevicePointBatch batch(int device) const {
    if (count > 0) {
      require_device(points, device, "points");
      if (radii != 0) require_device(radii, device, "max_distance");
    }
    const auto stride = [&](std::size_t rows, std::size_t size) {
      return rows == count ? size : 0;
    };
    return {
        .size = count,
        .points = {pointer<const treelet::Vec3>(points), stride(point_rows, sizeof(treelet::Vec3))},
        .radii = {pointer<const float>(radii), stride(radius_rows, sizeof(float))},
        .all_radii = all_radii};
  }
};

// Methods of the tree in files of their own.
void bind_device_hit_lists(nanobind::class_<treelet::cuda::DeviceBvh>& tree);
void bind_device_points(nanobind::module_& module,
                        nanobind::class_<treelet::cuda::DeviceBvh>& tree);
