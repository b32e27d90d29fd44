#include "support/exact_crossing.h"

#include <cmath>

#include <treelet/traverse/is_traceable.h>

namespace treelet::test {
namespace {

// Sheared coordinates are multiples of 2^-298 and less than 2^260: this is beside them nothing.
constexpr int kDisplacement = 2000;  // e = 2^-2000
constexpr int kFloatShift = 149;

struct ExactVec2 {
  BigInteger x, y;
};

/// times 2^4298, at which e and e^2 are whole.
ExactVec2 displaced(const Ray& ray, Vec3 vertex, int largest) {
  const auto at = [](float value, int shift) { return BigInteger::from_scaled(value, shift); };
  const int kx = (largest + 1) % 3, ky = (largest + 2) % 3;
  const auto relative = [&](int axis) {
    return at(vertex[axis], kFloatShift) - at(ray.origin[axis], kFloatShift);
  };
  const auto direction = [&](int axis) {
    return at(ray.direction[axis], kFloatShift + 2 * kDisplacement);
  };
  const auto sheared = [&](int axis) {
    return relative(axis) * direction(largest) - relative(largest) * direction(axis);
  };
  const BigInteger e = BigInteger::from_scaled(1.0, 2 * kFloatShift + kDisplacement);
  const BigInteger e_squared = BigInteger::from_scaled(1.0, 2 * kFloatShift);
  return {sheared(kx) - e, sheared(ky) - e_squared};
}

int side(const ExactVec2& p, const ExactVec2& q) { return (q.x * p.y - q.y * p.x).sign(); }

}  // namespace

ExactCrossing exact_crossing(const Ray& ray, const Triangle& triangle) {
  const Vec3 d = ray.direction;
  const float x = std::fabs(d.x), y = std::fabs(d.y), z = std::fabs(d.z);
  const int largest = x > y ? (x > z ? 0 : 2) : (y > z ? 1 : 2);
  const ExactVec2 a = displaced(ray, triangle.p0, largest);
  const ExactVec2 b = displaced(ray, triangle.p1, largest);
  const ExactVec2 c = displaced(ray, triangle.p2, largest);
  const int u = side(b, c);
  if (u == 0 || side(c, a) != u || side(a, b) != u) return {false, {}};
  return {true, exact_hit(ray, triangle).t};
}

int count_exact_crossings(const Ray& ray, const Mesh& mesh) {
  int count = 0;
  if (!is_traceable(ray)) return 0;
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
    const Triangle triangle = mesh.triangle(face);
    if (classify(triangle) != TriangleKind::regular) continue;
    if (!exact_hit(ray, triangle).is_hit)
      continue;  // crossings lie in the triangle, edges included
    const ExactCrossing crossing = exact_crossing(ray, triangle);
    count += crossing.crosses && crossing.t.numerator.sign() >= 0;
  }
  return count;
}

}  // namespace treelet::test
