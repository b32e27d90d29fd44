#pragma once

#include <treelet/core/aabb.h>
#include <treelet/mesh/mesh.h>
#include <treelet/primitive/power_of_two.h>
#include <treelet/primitive/reference.h>

// How triangles become references; host and device loop over it.

namespace treelet {

/// k such that the largest extent is in [2^(k-1), 2^k); 0 for a point or nothing. A difference of
/// floats is zero or at least 2^-149: a normal double.
TREELET_HD constexpr int extent_exponent(const Aabb& box) {
  if (box.is_empty()) return 0;
  double longest = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double extent = double(box.upper[axis]) - box.lower[axis];
    if (longest < extent) longest = extent;
  }
  return longest > 0.0 ? floor_log2(longest) + 1 : 0;
}

/// Takes coordinates of the mesh to build space: multiplies by 2^-exponent, for exponents of -148
/// to 129, rounding once; -0 becomes +0. Where 2^-exponent is beyond the largest float it takes two
/// steps: growing is exact. Coordinates beyond kBuildSpaceLimit become that.
class PowerOfTwoScale {
 public:
  TREELET_HD constexpr explicit PowerOfTwoScale(int exponent)
      : first_(float_power_of_two(-exponent > 127 ? 127 : -exponent)),
        second_(float_power_of_two(-exponent > 127 ? -exponent - 127 : 0)) {}

  /// Their product is 2^-exponent; to be multiplied by one after the other.
  TREELET_HD constexpr float first() const { return first_; }
  TREELET_HD constexpr float second() const { return second_; }

  TREELET_HD constexpr float operator()(float x) const {
    return max(-kBuildSpaceLimit, min(x * first_ * second_ + 0.0f, kBuildSpaceLimit));
  }
  TREELET_HD constexpr Vec3 operator()(Vec3 p) const {
    return {(*this)(p.x), (*this)(p.y), (*this)(p.z)};
  }
  TREELET_HD constexpr Aabb operator()(const Aabb& box) const {
    return {(*this)(box.lower), (*this)(box.upper)};
  }

 private:
  float first_, second_;
};

/// The reference of a regular triangle.
TREELET_HD constexpr Reference make_reference(const Triangle& triangle, std::uint32_t face,
                                              const PowerOfTwoScale& scale) {
  const Aabb box = scale(bounds(triangle));
  return {box.lower, face, box.upper, 0};
}

}  // namespace treelet
