#pragma once

#include <treelet/core/exact_steps.h>
#include <treelet/core/platform.h>

// Twice the digits of a double [Dekker1971], for quotients that are to be rounded right.

namespace treelet {

/// high + low, a number of about 106 bits. Each operation is off by less than 2^-102 of its result,
/// a sum of the sizes of what it adds.
struct DoubleDouble {
  double high = 0.0, low = 0.0;

  static TREELET_INLINE DoubleDouble difference(double a, double b) {
    const auto [sum, error] = exact_steps::two_sum(a, -b);
    return {sum, error};
  }
};

TREELET_INLINE DoubleDouble operator-(DoubleDouble a) { return {-a.high, -a.low}; }

TREELET_INLINE DoubleDouble operator+(DoubleDouble a, DoubleDouble b) {
  const auto [high, error] = exact_steps::two_sum(a.high, b.high);
  const auto [sum, low] = exact_steps::two_sum(high, error + (a.low + b.low));
  return {sum, low};
}
TREELET_INLINE DoubleDouble operator-(DoubleDouble a, DoubleDouble b) { return a + -b; }

TREELET_INLINE DoubleDouble operator*(DoubleDouble a, DoubleDouble b) {
  const auto [high, error] = exact_steps::two_product(a.high, b.high);
  const auto [sum, low] = exact_steps::two_sum(high, error + (a.high * b.low + a.low * b.high));
  return {sum, low};
}

TREELET_INLINE DoubleDouble operator/(DoubleDouble a, DoubleDouble b) {
  const double first = a.high / b.high;
  const DoubleDouble rest = a - b * DoubleDouble{first, 0.0};
  const auto [sum, low] = exact_steps::two_sum(first, rest.high / b.high);
  return {sum, low};
}

/// a . (p x q), also of numbers of other kinds.
template <class Number>
TREELET_INLINE Number triple_product(const Number (&a)[3], const Number (&p)[3],
                                     const Number (&q)[3]) {
  return a[0] * (p[1] * q[2] - p[2] * q[1]) + a[1] * (p[2] * q[0] - p[0] * q[2]) +
         a[2] * (p[0] * q[1] - p[1] * q[0]);
}

}  // namespace treelet
