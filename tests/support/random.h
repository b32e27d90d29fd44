#pragma once

#include <cstdint>

#include <treelet/core/vec.h>

namespace treelet::test {

/// SplitMix64: the same numbers from a seed everywhere, unlike the distributions of <random>.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  std::uint64_t bits() {
    std::uint64_t z = state_ += 0x9e3779b97f4a7c15;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9;
    z = (z ^ z >> 27) * 0x94d049bb133111eb;
    return z ^ z >> 31;
  }
  /// An integer in [0, end).
  std::uint64_t below(std::uint64_t end) { return bits() % end; }
  /// A float in [lower, upper).
  float uniform(float lower, float upper) {
    return lower + (upper - lower) * (float(bits() >> 40) * 0x1p-24f);
  }
  /// A point in [lower, upper)^3.
  Vec3 point(float lower, float upper) {
    const float x = uniform(lower, upper), y = uniform(lower, upper), z = uniform(lower, upper);
    return {x, y, z};
  }

 private:
  std::uint64_t state_;
};

}  // namespace treelet::test
