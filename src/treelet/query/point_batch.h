#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include <treelet/core/array.h>
#include <treelet/core/vec.h>
#include <treelet/query/ray_batch.h>

namespace treelet {

/// Points as they lie in memory, one radius for all or one each.
struct PointBatch {
  std::size_t size = 0;
  PerRay<Vec3> points;
  PerRay<float> radii{&kInfinite, 0};

  PointBatch() = default;
  PointBatch(std::span<const Vec3> all)  // NOLINT: an array of points is a batch
      : size(all.size()), points(all.data(), sizeof(Vec3)) {}

 private:
  static constexpr float kInfinite = std::numeric_limits<float>::infinity();
};

/// Numbers of points along a Z-order curve through them: neighbours share nodes and triangles.
/// Points that are not finite come first. At most 2^32 points.
Array<std::uint32_t> order_points(const PointBatch& points);

/// Below this, ordering costs more than it gains.
constexpr std::size_t kFewPoints = 512;

/// The points in the order in which they are best answered.
class PointOrder {
 public:
  explicit PointOrder(const PointBatch& points) {
    if (points.size > kFewPoints) order_ = order_points(points);
  }
  std::size_t operator()(std::size_t k) const { return order_.empty() ? k : order_[k]; }
  /// As RayBatch::order: null where the order is as given.
  const std::uint32_t* data() const { return order_.data(); }

 private:
  Array<std::uint32_t> order_;
};

}  // namespace treelet
