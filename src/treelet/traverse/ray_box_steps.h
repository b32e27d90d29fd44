#pragma once

#include <cmath>

#include <treelet/core/platform.h>
#include <treelet/traverse/ray_box.h>

// How a ray's RayBox is made; see traverse/ray_box.h for the bounds. Host and device call it.

namespace treelet::ray_box_steps {

constexpr float kSmallestComponent = 0x1p-22f;  // of a direction whose largest is in [1, 2)
constexpr float kPadding = 0x1p-20f;            // 16u
constexpr float kSmallestPadding = 0x1p-140f;   // where products underflow: 2^-150 each
constexpr float kRoundedOrigin = 0x1p-23f;   // 2u, of the coordinates of an origin that was moved
constexpr float kDoubleRounding = 0x1p-51f;  // of origin + t * direction, four times 2^-53
constexpr float kFar = 8.0f;                 // scene extents from which on moving it pays

TREELET_HD inline float largest_magnitude(Vec3 v) {
  return max(std::fabs(v.x), max(std::fabs(v.y), std::fabs(v.z)));
}

TREELET_HD inline float largest_distance(Vec3 origin, const Aabb& scene) {
  return max(largest_magnitude(origin - scene.lower), largest_magnitude(scene.upper - origin));
}

/// t where the ray comes nearest to the middle of the scene.
TREELET_HD inline double nearest_t(const Ray& ray, const Aabb& scene) {
  double along = 0.0, length = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double middle = 0.5 * (double(scene.lower[axis]) + scene.upper[axis]);
    const double direction = ray.direction[axis];
    along += (middle - ray.origin[axis]) * direction;
    length += direction * direction;
  }
  return along / length;
}

TREELET_HD inline Vec3 point_at(const Ray& ray, double t) {
  return {float(ray.origin.x + t * ray.direction.x), float(ray.origin.y + t * ray.direction.y),
          float(ray.origin.z + t * ray.direction.z)};
}

TREELET_HD inline void set_up(RayBox& box, const Ray& ray, const Aabb& scene) {
  Vec3 start = ray.origin;
  float distance = largest_distance(start, scene);
  float pad = kPadding * distance;
  if (distance > kFar * max_component(scene.extent())) {
    const float rounded_in_double = kDoubleRounding * distance;
    box.t_shift = nearest_t(ray, scene);
    start = point_at(ray, box.t_shift);
    distance = largest_distance(start, scene);
    pad = kPadding * distance + kRoundedOrigin * largest_magnitude(start) + rounded_in_double;
  }

  const int exponent = std::ilogb(largest_magnitude(ray.direction));
  box.t_scale = std::ldexp(1.0, exponent);
  const double to_unit = std::ldexp(1.0, -exponent);
  for (int axis = 0; axis < 3; ++axis) {
    const float component = float(ray.direction[axis] * to_unit);
    const float raised = max(std::fabs(component), kSmallestComponent);
    box.origin[axis] = start[axis];
    box.points_down[axis] = std::signbit(component);
    box.inverse[axis] = std::copysign(1.0f / raised, component);
    box.padding[axis] = (pad + kSmallestPadding) / raised;
  }
}

}  // namespace treelet::ray_box_steps
