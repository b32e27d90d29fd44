#pragma once

#include <treelet/core/platform.h>

namespace treelet {

/// Three floats: a point, a direction or an extent.
struct Vec3 {
  float x, y, z;

  TREELET_HD constexpr float operator[](int axis) const {
    return axis == 0 ? x : axis == 1 ? y : z;
  }
  friend constexpr bool operator==(const Vec3&, const Vec3&) = default;
};

TREELET_HD constexpr Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
TREELET_HD constexpr Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
TREELET_HD constexpr Vec3 operator*(Vec3 a, float s) { return {a.x * s, a.y * s, a.z * s}; }

// Written out instead of std::min: host and device must agree on which operand an equal pair gives.
TREELET_HD constexpr float min(float a, float b) { return b < a ? b : a; }
TREELET_HD constexpr float max(float a, float b) { return a < b ? b : a; }

TREELET_HD constexpr Vec3 min(Vec3 a, Vec3 b) {
  return {min(a.x, b.x), min(a.y, b.y), min(a.z, b.z)};
}
TREELET_HD constexpr Vec3 max(Vec3 a, Vec3 b) {
  return {max(a.x, b.x), max(a.y, b.y), max(a.z, b.z)};
}
TREELET_HD constexpr float max_component(Vec3 a) { return max(a.x, max(a.y, a.z)); }

}  // namespace treelet
