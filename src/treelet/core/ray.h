#pragma once

#include <cstdint>
#include <limits>

#include <treelet/core/vec.h>

namespace treelet {

/// Points origin + t * direction with t in [t_min, t_max]. The direction need not be unit length:
/// t is measured in units of it.
struct Ray {
  Vec3 origin{0, 0, 0};
  Vec3 direction{0, 0, 1};
  float t_min = 0.0f;
  float t_max = std::numeric_limits<float>::infinity();
};

/// A hit at (1-u-v) P0 + u P1 + v P2 of `face`; a miss has t = inf and face = -1.
struct Hit {
  float t = std::numeric_limits<float>::infinity();
  std::int32_t face = -1;
  float u = 0.0f;
  float v = 0.0f;

  bool is_hit() const { return face >= 0; }
  friend bool operator==(const Hit&, const Hit&) = default;
};

}  // namespace treelet
