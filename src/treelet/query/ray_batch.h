#pragma once

#include <cstddef>
#include <cstring>
#include <span>

#include <treelet/core/platform.h>
#include <treelet/core/ray.h>

namespace treelet {

/// A value for each ray somewhere in the caller's memory.
template <class T>
struct PerRay {
  const std::byte* first = nullptr;
  std::size_t stride = sizeof(T);  ///< bytes from one ray's value to the next; 0: one for all

  PerRay() = default;
  PerRay(const T* data, std::size_t stride_bytes)
      : first(reinterpret_cast<const std::byte*>(data)), stride(stride_bytes) {}

  TREELET_HD T operator[](std::size_t ray) const {
#if defined(__CUDA_ARCH__)
    return *reinterpret_cast<const T*>(first + ray * stride);  // device arrays are aligned
#else
    T value;
    std::memcpy(&value, first + ray * stride, sizeof(T));
    return value;
#endif
  }
};

/// Rays as they lie in memory: arrays of parts, or an array of rays.
struct RayBatch {
  std::size_t size = 0;
  PerRay<Vec3> origins, directions;
  PerRay<float> t_min{&kDefaults.t_min, 0}, t_max{&kDefaults.t_max, 0};

  RayBatch() = default;
  RayBatch(std::span<const Ray> rays)  // NOLINT: an array of rays is a batch
      : size(rays.size()) {
    if (rays.empty()) return;
    origins = {&rays[0].origin, sizeof(Ray)};
    directions = {&rays[0].direction, sizeof(Ray)};
    t_min = {&rays[0].t_min, sizeof(Ray)};
    t_max = {&rays[0].t_max, sizeof(Ray)};
  }

  Ray operator[](std::size_t i) const { return {origins[i], directions[i], t_min[i], t_max[i]}; }

 private:
  static constexpr Ray kDefaults{};
};

}  // namespace treelet
