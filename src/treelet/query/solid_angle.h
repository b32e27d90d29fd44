#pragma once

#include <cmath>
#include <numbers>

#include <treelet/core/platform.h>
#include <treelet/query/point_triangle_steps.h>

namespace treelet {

/// Sums the solid angles of triangles, in doubles. A triangle's half angle is that of a complex
/// number [VanOosteromStrackee1983]; the numbers are multiplied, full turns counted, and one
/// arctangent is taken at the end.
class SolidAngleSum {
 public:
  /// Vertices relative to the eye. Positive where the triangle is seen clockwise, from behind. A
  /// triangle seen edge-on, or from a point on it, adds nothing.
  TREELET_HD void add(const point_steps::DoubleVector& a, const point_steps::DoubleVector& b,
                      const point_steps::DoubleVector& c) {
    using point_steps::dot;
    const double sine = dot(a, point_steps::cross(b, c));
    if (sine == 0.0) return;
    const double la = std::sqrt(dot(a, a)), lb = std::sqrt(dot(b, b)), lc = std::sqrt(dot(c, c));
    const double cosine = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb;
    const double scale = 1.0 / (std::fabs(sine) + std::fabs(cosine));
    multiply(cosine * scale, sine * scale);
  }

  TREELET_HD double sum() const {
    return 2.0 * std::atan2(imaginary_, real_) + 4.0 * std::numbers::pi * turns_;
  }

 private:
  TREELET_HD void multiply(double real, double imaginary) {
    const double product_real = real_ * real - imaginary_ * imaginary;
    const double product = real_ * imaginary + imaginary_ * real;
    if (imaginary_ >= 0.0 && imaginary > 0.0 && product < 0.0) ++turns_;
    if (imaginary_ < 0.0 && imaginary < 0.0 && product >= 0.0) --turns_;
    const double scale = 1.0 / (std::fabs(product_real) + std::fabs(product));
    real_ = product_real * scale;
    imaginary_ = product * scale;
  }

  double real_ = 1.0, imaginary_ = 0.0;
  int turns_ = 0;
};

}  // namespace treelet
