#include <treelet/traverse/ray_box.h>

#include <cmath>

namespace treelet {
namespace {

constexpr float kSmallestComponent = 0x1p-22f;  // of a direction whose largest is in [1, 2)
constexpr float kPadding = 0x1p-20f;            // 16u
constexpr float kSmallestPadding = 0x1p-140f;   // where products underflow: 2^-150 each

float largest_distance(Vec3 origin, const Aabb& scene) {
  const Vec3 below = origin - scene.lower, above = scene.upper - origin;
  float distance = 0.0f;
  for (int axis = 0; axis < 3; ++axis) {
    distance = max(distance, max(std::fabs(below[axis]), std::fabs(above[axis])));
  }
  return distance;
}

}  // namespace

RayBox::RayBox(const Ray& ray, const Aabb& scene)
    : origin{ray.origin.x, ray.origin.y, ray.origin.z} {
  const Vec3 d = ray.direction;
  const int exponent = std::ilogb(max(std::fabs(d.x), max(std::fabs(d.y), std::fabs(d.z))));
  t_scale = std::ldexp(1.0, exponent);
  const double to_unit = std::ldexp(1.0, -exponent);
  const float distance = largest_distance(ray.origin, scene);
  for (int axis = 0; axis < 3; ++axis) {
    const float component = float(d[axis] * to_unit);
    const float raised = max(std::fabs(component), kSmallestComponent);
    points_down[axis] = std::signbit(component);
    inverse[axis] = std::copysign(1.0f / raised, component);
    padding[axis] = (kPadding * distance + kSmallestPadding) / raised;
  }
}

}  // namespace treelet
