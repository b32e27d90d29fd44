#pragma once

#include <array>
#include <cmath>

#include <treelet/core/platform.h>
#include <treelet/core/vec.h>

// Expansions after [Shewchuk1997]: a value is the exact sum of doubles in increasing magnitude, no
// two of which have bits in adjacent places. Products of three floats and their rounding errors
// stay between 1e-240 and 1e120, so nothing here overflows or underflows.

namespace treelet::exact_steps {

struct TwoTerms {
  double high, low;  // high + low is exact, high its rounding
};

TREELET_INLINE TwoTerms two_sum(double a, double b) {
  const double sum = a + b;
  const double b_part = sum - a;
  return {sum, (a - (sum - b_part)) + (b - b_part)};
}

TREELET_INLINE TwoTerms two_product(double a, double b) {
  const double product = a * b;
  return {product, std::fma(a, b, -product)};
}

/// A sum of terms without zeros. Capacity: six products of a direction component (1 term) and two
/// differences (2 terms each) are 6 * 2 * 2 products of two terms, times a factor: 96 terms.
class Expansion {
 public:
  TREELET_HD void add(double term) {
    int kept = 0;
    for (int i = 0; i < size_; ++i) {
      const TwoTerms sum = two_sum(term, terms_[i]);
      if (sum.low != 0.0) terms_[kept++] = sum.low;
      term = sum.high;
    }
    if (term != 0.0) terms_[kept++] = term;
    size_ = kept;
  }

  TREELET_HD void add_product(double a, double b, double c) {
    if (a == 0.0 || b == 0.0 || c == 0.0) return;
    const TwoTerms ab = two_product(a, b);
    const TwoTerms high = two_product(ab.high, c);
    const TwoTerms low = two_product(ab.low, c);
    for (const double term : {low.low, low.high, high.low, high.high}) {
      if (term != 0.0) add(term);
    }
  }

  /// Adding a term to a nonadjacent expansion leaves a nonadjacent one, so the largest term decides
  /// the sign, and summing from the small end up keeps it.
  TREELET_HD double rounded() const {
    double sum = 0.0;
    for (int i = 0; i < size_; ++i) sum += terms_[i];
    return sum;
  }

 private:
  double terms_[96];
  int size_ = 0;
};

/// factor * a * b for differences a and b of two terms each.
TREELET_HD inline void add_minor(Expansion& sum, double factor, TwoTerms a, TwoTerms b) {
  for (const double a_term : {a.low, a.high}) {
    for (const double b_term : {b.low, b.high}) sum.add_product(a_term, b_term, factor);
  }
}

TREELET_HD inline std::array<TwoTerms, 3> difference(Vec3 a, Vec3 b) {
  return {two_sum(a.x, -double(b.x)), two_sum(a.y, -double(b.y)), two_sum(a.z, -double(b.z))};
}

/// exact_triple_product (core/exact.h) for host and device.
TREELET_HD TREELET_NOINLINE inline double triple_product(Vec3 direction, Vec3 origin, Vec3 a,
                                                         Vec3 b) {
  const std::array<TwoTerms, 3> p = difference(a, origin);
  const std::array<TwoTerms, 3> q = difference(b, origin);
  Expansion sum;
  for (int axis = 0; axis < 3; ++axis) {
    const int next = (axis + 1) % 3, after = (axis + 2) % 3;
    add_minor(sum, direction[axis], p[next], q[after]);
    add_minor(sum, -double(direction[axis]), p[after], q[next]);
  }
  return sum.rounded();
}

}  // namespace treelet::exact_steps
