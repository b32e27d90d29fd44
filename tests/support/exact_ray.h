#pragma once

#include <array>

#include <treelet/core/aabb.h>
#include <treelet/core/ray.h>
#include <treelet/mesh/mesh.h>

#include "support/big_integer.h"

// What a ray meets, in integers: the oracle of the traversal tests. Everything takes its floats as
// they are, each a multiple of 2^-149.

namespace treelet::test {

using ExactVec3 = std::array<BigInteger, 3>;

/// A quotient whose denominator is positive, or zero where there is none.
struct Fraction {
  BigInteger numerator, denominator;
};

/// Whether the ray's line meets the triangle, which it does not where they are coplanar, and where:
/// t, u and v.
struct ExactHit {
  bool is_hit;
  Fraction t, u, v;
};
ExactHit exact_hit(const Ray& ray, const Triangle& triangle);

/// |value - expected| <= tolerance * max(|value|, scale).
bool is_near(double value, const Fraction& expected, double tolerance, double scale);

/// Whether some point origin + t * direction with t in [t_min, t_max] lies in the box, sides
/// included. Both limits must be finite.
bool exact_meets_box(const Ray& ray, const Aabb& box);

}  // namespace treelet::test
