#include "support/exact_ray.h"

#include <algorithm>

namespace treelet::test {
namespace {

constexpr int kFloatShift = 149;

BigInteger exact(float value) { return BigInteger::from_scaled(value, kFloatShift); }
ExactVec3 exact(Vec3 v) { return {exact(v.x), exact(v.y), exact(v.z)}; }

ExactVec3 operator-(const ExactVec3& a, const ExactVec3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
ExactVec3 cross(const ExactVec3& a, const ExactVec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
BigInteger dot(const ExactVec3& a, const ExactVec3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Fraction fraction(const BigInteger& numerator, const BigInteger& denominator) {
  if (denominator.sign() < 0) return {-numerator, -denominator};
  return {numerator, denominator};
}

bool less(const Fraction& a, const Fraction& b) {
  return (a.numerator * b.denominator - b.numerator * a.denominator).sign() < 0;
}

}  // namespace

ExactHit exact_hit(const Ray& ray, const Triangle& triangle) {
  const ExactVec3 direction = exact(ray.direction), origin = exact(ray.origin);
  const ExactVec3 a = exact(triangle.p0) - origin, b = exact(triangle.p1) - origin,
                  c = exact(triangle.p2) - origin;
  const BigInteger u = dot(direction, cross(c, b)), v = dot(direction, cross(a, c)),
                   w = dot(direction, cross(b, a));
  const BigInteger sum = u + v + w;
  const int most = std::max({u.sign(), v.sign(), w.sign()});
  const int least = std::min({u.sign(), v.sign(), w.sign()});
  if (most * least < 0 || sum.sign() == 0) return {false, {}, {}, {}};
  const ExactVec3 normal = cross(c - a, b - a);
  return {true, fraction(dot(normal, a), sum), fraction(v, sum), fraction(w, sum)};
}

bool is_near(double value, const Fraction& expected, double tolerance, double scale) {
  constexpr int kShift = 1074;  // every double is a multiple of 2^-1074
  const auto scaled = [](double x) { return BigInteger::from_scaled(x, kShift); };
  const BigInteger one = scaled(1.0);
  const BigInteger error =
      (scaled(value) * expected.denominator - one * expected.numerator).magnitude();
  const double bound = tolerance * std::max(std::fabs(value), scale);
  return (error - scaled(bound) * expected.denominator).sign() <= 0;
}

bool exact_meets_box(const Ray& ray, const Aabb& box) {
  const BigInteger one = exact(1.0f);
  Fraction near{exact(ray.t_min), one}, far{exact(ray.t_max), one};
  for (int axis = 0; axis < 3; ++axis) {
    const BigInteger d = exact(ray.direction[axis]), o = exact(ray.origin[axis]);
    const BigInteger lower = exact(box.lower[axis]) - o, upper = exact(box.upper[axis]) - o;
    if (d.sign() == 0) {
      if (lower.sign() > 0 || upper.sign() < 0) return false;
      continue;
    }
    const Fraction first = fraction(d.sign() > 0 ? lower : upper, d);
    const Fraction last = fraction(d.sign() > 0 ? upper : lower, d);
    if (less(near, first)) near = first;
    if (less(last, far)) far = last;
  }
  return !less(far, near);
}

}  // namespace treelet::test
