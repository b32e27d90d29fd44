#pragma once

#include <cstdint>
#include <limits>

#include <treelet/core/double_vec.h>

namespace treelet {

/// Ray (core/ray.h) in doubles.
struct DoubleRay {
  DoubleVec3 origin{0, 0, 0};
  DoubleVec3 direction{0, 0, 1};
  double t_min = 0.0;
  double t_max = std::numeric_limits<double>::infinity();
};

/// Hit in doubles: t, u and v are the exact ones, rounded once.
struct DoubleHit {
  double t = std::numeric_limits<double>::infinity();
  double u = 0.0;
  double v = 0.0;
  std::int32_t face = -1;

  bool is_hit() const { return face >= 0; }
  friend bool operator==(const DoubleHit&, const DoubleHit&) = default;
};

}  // namespace treelet
