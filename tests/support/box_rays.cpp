#include "support/box_rays.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace treelet::test {
namespace {

/// A point of the box, on some of its sides as often as not: faces, edges and corners.
Vec3 point_on_sides(Random& random, const Aabb& box) {
  const auto coordinate = [&](float lower, float upper) {
    const std::uint64_t side = random.below(4);
    return side == 0 ? lower : side == 1 ? upper : random.uniform(lower, upper);
  };
  const float x = coordinate(box.lower.x, box.upper.x), y = coordinate(box.lower.y, box.upper.y);
  return {x, y, coordinate(box.lower.z, box.upper.z)};
}

Vec3 random_direction(Random& random) {
  Vec3 direction = random.point(-1.0f, 1.0f);
  if (random.below(3) == 0) direction.x = 0.0f;
  if (random.below(3) == 0) direction.y = 0.0f;
  if (random.below(6) == 0) direction.z *= 1e-6f;
  if (random.below(6) == 0) direction.x = 1e-9f;
  if (direction == Vec3{0, 0, 0}) direction.z = -1.0f;
  return direction;
}

}  // namespace

Aabb random_box(Random& random) {
  const Vec3 lower = random.point(-1.0f, 1.0f);
  Vec3 extent = random.point(0.0f, 1.0f) * std::ldexp(1.0f, -int(random.below(24)));
  if (random.below(3) == 0) extent.x = 0.0f;
  if (random.below(3) == 0) extent.y = 0.0f;
  if (random.below(3) == 0) extent.z = 0.0f;
  return {lower, lower + extent};
}

Ray random_ray_at(Random& random, const Aabb& box) {
  const Vec3 target = point_on_sides(random, box);
  const Vec3 direction = random_direction(random);
  const float distance = std::ldexp(random.uniform(-1.0f, 1.0f), int(random.below(20)));
  Ray ray;
  ray.origin = target - direction * distance;
  ray.direction = direction * std::ldexp(1.0f, int(random.below(41)) - 20);
  const float t = distance * (direction.x != 0.0f   ? direction.x / ray.direction.x
                              : direction.y != 0.0f ? direction.y / ray.direction.y
                                                    : direction.z / ray.direction.z);
  const std::uint64_t limits = random.below(4);
  ray.t_min = limits == 0 ? t : std::min(t, 0.0f) - std::fabs(t);
  ray.t_max = limits == 1 ? t : ray.t_min + 4.0f * std::fabs(t) + 1e-30f;
  if (limits == 3) ray.t_max = std::nextafter(t, -std::numeric_limits<float>::infinity());
  return ray;
}

std::ostream& operator<<(std::ostream& out, const Scale& scale) { return out << scale.name; }

Aabb scaled(const Aabb& box, float factor) { return {box.lower * factor, box.upper * factor}; }

Ray scaled(const Ray& ray, float factor) {
  return {ray.origin * factor, ray.direction * factor, ray.t_min, ray.t_max};
}

}  // namespace treelet::test
