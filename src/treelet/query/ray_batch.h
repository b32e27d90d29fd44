#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>

#include <treelet/core/platform.h>
#include <treelet/core/ray.h>
#include <treelet/traverse/face_filter.h>

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

  /// Values of the rays from one on.
  PerRay from(std::size_t ray) const {
    PerRay rest = *this;
    if (first != nullptr) rest.first += ray * stride;
    return rest;
  }
};

/// Rays as they lie in memory: arrays of parts, or an array of rays.
struct RayBatch {
  std::size_t size = 0;
  PerRay<Vec3> origins, directions;
  PerRay<float> t_min{&kDefaults.t_min, 0}, t_max{&kDefaults.t_max, 0};
  /// The k-th ray to trace is order[k]; null: ray k. Answers lie in the places of their rays.
  const std::uint32_t* order = nullptr;
  /// Rays in a row of the picture that they make; 0: none. Without an order, closest and any hits
  /// are found by tiles of 4 x 4, whose rays stay closer together than those of a row.
  std::size_t row = 0;
  /// Rays that are traced; the others miss. None given: all.
  PerRay<bool> active;
  FaceFilter filter;  ///< faces that the rays can hit

  RayBatch() = default;
  RayBatch(std::span<const Ray> rays)  // NOLINT: an array of rays is a batch
      : size(rays.size()) {
    if (rays.empty()) return;
    origins = {&rays[0].origin, sizeof(Ray)};
    directions = {&rays[0].direction, sizeof(Ray)};
    t_min = {&rays[0].t_min, sizeof(Ray)};
    t_max = {&rays[0].t_max, sizeof(Ray)};
  }

  /// One that is not active has a limit that is NaN, so that it misses wherever it is traced.
  Ray operator[](std::size_t i) const {
    constexpr float nan = std::numeric_limits<float>::quiet_NaN();
    return {origins[i], directions[i], is_active(i) ? t_min[i] : nan, t_max[i]};
  }
  bool is_active(std::size_t i) const { return active.first == nullptr || active[i]; }
  std::size_t ray_of(std::size_t k) const { return order == nullptr ? k : order[k]; }

  /// Likewise by tiles: the numbers of the k-th rays to trace, for k in [begin, end).
  void list_rays(std::size_t begin, std::size_t end, std::size_t* numbers) const {
    const std::size_t tiled = order == nullptr ? count_tiled() : 0;
    std::size_t corner = 0;  // of the tile
    for (std::size_t k = begin; k < end; ++k) {
      if (k >= tiled) {
        *numbers++ = ray_of(k);
        continue;
      }
      if (k == begin || k % kTile == 0) corner = corner_of(k / kTile);
      *numbers++ = corner + k % kTile / kTileWidth * row + k % kTileWidth;
    }
  }

  /// `count` rays from one on. An order is one of the whole batch, so a part is in the given one;
  /// rows stay where the part begins with one. Answers depend on neither.
  RayBatch part(std::size_t begin, std::size_t count) const {
    RayBatch rays = *this;
    rays.size = count;
    rays.order = nullptr;
    if (row != 0 && begin % row != 0) rays.row = 0;
    rays.origins = origins.from(begin);
    rays.directions = directions.from(begin);
    rays.t_min = t_min.from(begin);
    rays.t_max = t_max.from(begin);
    rays.active = active.from(begin);
    return rays;
  }

 private:
  static constexpr Ray kDefaults{};
  static constexpr std::size_t kTileWidth = 4, kTile = kTileWidth * kTileWidth;

  /// Rays of the rows that whole tiles fill, which come first.
  std::size_t count_tiled() const {
    if (row == 0 || row % kTileWidth != 0) return 0;
    return size / (row * kTileWidth) * (row * kTileWidth);
  }
  /// The first ray of a tile; tiles are numbered along the rows.
  std::size_t corner_of(std::size_t tile) const {
    const std::size_t tiles = row / kTileWidth;
    return tile / tiles * kTileWidth * row + tile % tiles * kTileWidth;
  }
};

}  // namespace treelet
