#include <treelet/traverse/face_filter.h>

#include <cmath>

#include <treelet/core/exact.h>

namespace treelet {

int side_of(Vec3 direction, const Triangle& triangle) {
  // A difference of floats and a product each lose u = 2^-53 of themselves at most, and the
  // sum five of its six terms' magnitudes: 8u in all, to first order. The bound is twice that.
  constexpr double kError = 0x1p-49;
  double e[3], f[3];
  for (int i = 0; i < 3; ++i) {
    e[i] = double(triangle.p1[i]) - triangle.p0[i];
    f[i] = double(triangle.p2[i]) - triangle.p0[i];
  }
  double sum = 0.0, magnitudes = 0.0;
  for (int i = 0; i < 3; ++i) {
    const int next = (i + 1) % 3, after = (i + 2) % 3;
    const double left = e[next] * f[after], right = e[after] * f[next];
    sum += direction[i] * (left - right);
    magnitudes += std::fabs(double(direction[i])) * (std::fabs(left) + std::fabs(right));
  }
  if (!(std::fabs(sum) > kError * magnitudes)) {
    sum = exact_triple_product(direction, triangle.p0, triangle.p1, triangle.p2);
  }
  return (sum > 0.0) - (sum < 0.0);
}

bool FaceFilter::shows(Vec3 direction, const Triangle& triangle) const {
  if (cull == Cull::none) return true;
  return (side_of(direction, triangle) < 0) == (cull == Cull::back);
}

}  // namespace treelet
