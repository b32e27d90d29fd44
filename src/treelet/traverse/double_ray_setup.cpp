#include <treelet/traverse/double_ray_setup.h>

#include <algorithm>
#include <cmath>

#include <treelet/primitive/power_of_two.h>
#include <treelet/traverse/ray_box_steps.h>

namespace treelet {
namespace {

bool is_traceable(const DoubleRay& ray) {
  double sum = 0.0;
  for (int axis = 0; axis < 3; ++axis) sum += ray.origin[axis] * 0.0 + ray.direction[axis] * 0.0;
  const bool is_finite = sum == 0.0;  // infinity and NaN times zero are NaN
  return is_finite && ray.direction != DoubleVec3{0, 0, 0} && ray.t_min <= ray.t_max;
}

/// std::ldexp(1.0, exponent), at once for all exponents that are not extreme.
double two_to_the(int exponent) {
  if (exponent < -1022 || exponent > 1023) return std::ldexp(1.0, exponent);
  return power_of_two(exponent);
}

/// std::ilogb, likewise, for positive numbers.
int exponent_of(double x) { return x < 0x1p-1022 ? std::ilogb(x) : floor_log2(x); }

/// A direction scaled by 2^-exponent.
DoubleVec3 scale_down(const DoubleVec3& v, int exponent) {
  // One factor might be infinite.
  const double first = two_to_the(-exponent / 2), second = two_to_the(-exponent - -exponent / 2);
  return {v.x * first * second, v.y * first * second, v.z * first * second};
}

int largest_axis(const DoubleVec3& v) {
  const double x = std::fabs(v.x), y = std::fabs(v.y), z = std::fabs(v.z);
  return x > y ? (x > z ? 0 : 2) : (y > z ? 1 : 2);
}

/// The ray in the frame: start + s * unit.
struct FramedRay {
  double start[3], unit[3];

  double largest_distance(const Aabb& scene) const {
    double distance = 0.0;
    for (int i = 0; i < 3; ++i) {
      distance = std::max(
          {distance, std::fabs(start[i] - scene.lower[i]), std::fabs(scene.upper[i] - start[i])});
    }
    return distance;
  }
  double largest_coordinate() const {
    return std::max({std::fabs(start[0]), std::fabs(start[1]), std::fabs(start[2])});
  }
  /// Moves the start to where the ray comes nearest to the scene's middle; returns by which s.
  double move_near(const Aabb& scene) {
    double along = 0.0, length = 0.0;
    for (int i = 0; i < 3; ++i) {
      along += (0.5 * (double(scene.lower[i]) + scene.upper[i]) - start[i]) * unit[i];
      length += unit[i] * unit[i];
    }
    const double shift = along / length;
    for (int i = 0; i < 3; ++i) start[i] += shift * unit[i];
    return shift;
  }
};

/// For `exponent`, that of the direction's largest component.
void set_up_box(DoubleRayBox& box, FramedRay ray, const Aabb& scene, int exponent) {
  using namespace ray_box_steps;
  const double given_distance = ray.largest_distance(scene);
  const bool is_far = !(given_distance <= double(kFar) * max_component(scene.extent()));
  box.t_shift = is_far ? ray.move_near(scene) : 0.0;
  const double padding = double(kPadding) * ray.largest_distance(scene) +
                         double(kRoundedOrigin) * ray.largest_coordinate() +
                         double(kDoubleRounding) * given_distance + double(kSmallestPadding);
  box.padding = float(padding * (1.0 + 0x1p-20));
  for (int i = 0; i < 3; ++i) {
    const double raised = std::max(std::fabs(ray.unit[i]), double(kSmallestComponent));
    box.start[i] = float(ray.start[i]);
    box.inverse[i] = float(std::copysign(1.0 / raised, ray.unit[i]));
  }
  box.t_scale[0] = two_to_the(exponent / 2);
  box.t_scale[1] = two_to_the(exponent - exponent / 2);
}

}  // namespace

bool prepare(const DoubleRay& ray, const BoxFrame& frame, const Aabb& scene,
             DoubleRaySetup& setup) {
  if (!is_traceable(ray)) return false;
  const int largest = largest_axis(ray.direction);
  const int exponent = exponent_of(std::fabs(ray.direction[largest]));
  const double to_frame = two_to_the(-frame.exponent);
  const DoubleVec3 unit = scale_down(ray.direction, exponent);
  FramedRay framed;
  for (int i = 0; i < 3; ++i) {
    framed.start[i] = (ray.origin[i] - frame.center[i]) * to_frame;
    framed.unit[i] = unit[i];
  }
  set_up_box(setup.box, framed, scene, exponent - frame.exponent);
  setup.ray = &ray;
  for (int i = 0; i < 3; ++i) {
    setup.axis[i] = (largest + 1 + i) % 3;
    setup.origin[i] = ray.origin[setup.axis[i]];
    setup.unit[i] = framed.unit[setup.axis[i]];
  }
  setup.z_of_t = std::fabs(ray.direction[largest]);
  setup.set_lower_limit(ray.t_min);
  setup.set_upper_limit(ray.t_max);
  return true;
}

}  // namespace treelet
