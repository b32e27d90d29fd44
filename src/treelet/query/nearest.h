#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>

#include <treelet/core/platform.h>
#include <treelet/core/vec.h>

namespace treelet {

/// A point whose nearest triangle is looked for.
struct NearestQuery {
  Vec3 point;
  /// Only triangles at most so far count, squared; infinite for all.
  double largest = std::numeric_limits<double>::infinity();
};

/// The nearest triangle so far; of equal squared distances the one with the smaller face. The
/// answer does not depend on the order in which triangles are met.
struct Nearest {
  static constexpr std::uint32_t kNone = 0xffffffff;

  double squared_distance = std::numeric_limits<double>::infinity();
  std::uint32_t face = kNone;
  std::uint32_t position = 0;  ///< of the triangle in the layout

  TREELET_HD bool is_none() const { return face == kNone; }
};

}  // namespace treelet
