#pragma once

#include <cstdint>

namespace treelet {

/// Number `index` of a random sequence: of nothing but its place, so that threads may ask in any
/// order. A SplitMix64 step.
constexpr std::uint64_t random_bits(std::uint64_t sequence, std::uint64_t index) {
  std::uint64_t z = sequence * 0xd1342543de82ef95 + (index + 1) * 0x9e3779b97f4a7c15;
  z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9;
  z = (z ^ z >> 27) * 0x94d049bb133111eb;
  return z ^ z >> 31;
}

/// In [0, 1).
constexpr float to_unit_float(std::uint64_t bits) { return float(bits >> 40) * 0x1p-24f; }

}  // namespace treelet
