#include <treelet/query/spawn.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <treelet/core/exact.h>
#include <treelet/traverse/face_filter.h>

namespace treelet {
namespace {

using Coordinates = std::array<double, 3>;

Coordinates edge(Vec3 from, Vec3 to) {
  return {double(to.x) - from.x, double(to.y) - from.y, double(to.z) - from.z};
}

/// The product of two edges. A coordinate that rounding may have spoilt is computed exactly: the
/// error is below 2^-49 of its terms (side_of), so what is above 2^-30 of them is right to 2^-19.
Coordinates cross_edges(const Triangle& triangle) {
  const Coordinates e = edge(triangle.p0, triangle.p1), f = edge(triangle.p0, triangle.p2);
  Coordinates normal;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t next = (i + 1) % 3, after = (i + 2) % 3;
    const double left = e[next] * f[after], right = e[after] * f[next];
    normal[i] = left - right + 0.0;  // -0 to +0
    const double terms = std::fabs(left) + std::fabs(right);
    if (terms == 0.0 || std::fabs(normal[i]) > 0x1p-30 * terms) continue;
    const Vec3 axis{float(i == 0), float(i == 1), float(i == 2)};
    normal[i] = exact_triple_product(axis, triangle.p0, triangle.p1, triangle.p2);
  }
  return normal;
}

double length(const Coordinates& v) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

/// The float next to x that does not lie against `towards`, of which the sign counts.
float round_towards(double x, double towards) {
  constexpr float inf = std::numeric_limits<float>::infinity();
  const auto rounded = float(x);
  if (towards > 0.0 && rounded < x) return std::nextafter(rounded, inf);
  if (towards < 0.0 && rounded > x) return std::nextafter(rounded, -inf);
  return rounded;
}

/// How far an origin must be from the triangle's plane.
///
/// With u = 2^-24, e the triangle's extent and z the distance of its farthest corner from the
/// origin along the ray's largest axis, t is computed as a distance along that axis that is off by
/// less than 2^-24.4 z: U, V and W are off by half of `bound` each, and their sum, where it is not
/// exact, is more than 2^26 of it. A plane d behind the origin is at least d / sqrt(3) behind it on
/// that axis, so t is negative from d = 2^-23.6 z on; z is at most e, d and a float of the largest
/// coordinate m, which the terms have room for, as for interpolating in doubles. The last two keep
/// t from rounding to zero, and the plane behind an origin that went through coordinates in
/// doubles.
double clearance(double extent, double largest, Vec3 direction, double far) {
  const double fastest =
      std::max({std::fabs(direction.x), std::fabs(direction.y), std::fabs(direction.z)});
  return 0x1p-22 * extent + 0x1p-44 * largest + 0x1p-147 * fastest + 0x1p-50 * far;
}

}  // namespace

Vec3 unit_normal(const Triangle& triangle) {
  const Coordinates normal = cross_edges(triangle);
  const double size = length(normal);  // 0 makes NaN
  return {float(normal[0] / size), float(normal[1] / size), float(normal[2] / size)};
}

Vec3 spawn_origin(const Triangle& triangle, float u, float v, Vec3 direction, double far) {
  const Vec3 a = triangle.p0, b = triangle.p1, c = triangle.p2;
  double extent = 0.0, largest = 0.0;
  for (int i = 0; i < 3; ++i) {
    const auto [least, most] = std::minmax({double(a[i]), double(b[i]), double(c[i])});
    extent = std::max(extent, most - least);
    largest = std::max({largest, -least, most});
  }
  const Coordinates normal = cross_edges(triangle), e = edge(a, b), f = edge(a, c);
  const double size = length(normal);
  const double side = side_of(direction, triangle) < 0 ? -1.0 : 1.0;
  const double distance =
      size > 0.0 ? side * clearance(extent, largest, direction, far) / size : 0.0;
  float origin[3];
  for (std::size_t i = 0; i < 3; ++i) {
    const double point = a[int(i)] + u * e[i] + v * f[i];
    origin[i] = round_towards(point + distance * normal[i], distance * normal[i]);
  }
  return {origin[0], origin[1], origin[2]};
}

}  // namespace treelet
