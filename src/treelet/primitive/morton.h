#pragma once

#include <array>
#include <cstdint>

#include <treelet/core/aabb.h>

namespace treelet {

/// Splits a scene's box into 2^63 near-cubic cells and numbers them along a Z-order curve: bits go
/// to the axes by extent, the longest axis first. Differs from 21 bits for each axis [Karras2012
/// s3]: on a room of 4:2:1, codes that halve the longest side first give a better LBVH for nothing.
struct MortonGrid {
  std::array<std::uint8_t, 3> axis{0, 1, 2};  ///< axes by falling extent
  std::array<std::uint8_t, 3> bits{0, 0, 0};  ///< bits of those axes, falling; they sum to <= 63
  std::array<double, 3> lower{};              ///< of doubled centroids, by those axes
  std::array<double, 3> scale{};              ///< cells a unit
};

constexpr int kMortonBits = 63;

/// For doubled centroids of boxes inside `bounds`.
MortonGrid make_morton_grid(const Aabb& bounds);

/// Spreads the low 21 bits of x to every third bit.
TREELET_HD constexpr std::uint64_t spread_by_3(std::uint64_t x) {
  x &= 0x1fffff;
  x = (x | x << 32) & 0x001f00000000ffff;
  x = (x | x << 16) & 0x001f0000ff0000ff;
  x = (x | x << 8) & 0x100f00f00f00f00f;
  x = (x | x << 4) & 0x10c30c30c30c30c3;
  x = (x | x << 2) & 0x1249249249249249;
  return x;
}

/// Spreads the low 32 bits of x to every second bit.
TREELET_HD constexpr std::uint64_t spread_by_2(std::uint64_t x) {
  x &= 0xffffffff;
  x = (x | x << 16) & 0x0000ffff0000ffff;
  x = (x | x << 8) & 0x00ff00ff00ff00ff;
  x = (x | x << 4) & 0x0f0f0f0f0f0f0f0f;
  x = (x | x << 2) & 0x3333333333333333;
  x = (x | x << 1) & 0x5555555555555555;
  return x;
}

/// Cell coordinates, the axis with most bits first, to a code. From the top: the bits that only the
/// longest axis has, then pairs of the two longer ones, then triples of all.
TREELET_HD constexpr std::uint64_t interleave(const std::array<std::uint8_t, 3>& bits,
                                              std::uint64_t a, std::uint64_t b, std::uint64_t c) {
  const int triples = bits[2], pairs = bits[1] - bits[2];
  const std::uint64_t low = (std::uint64_t{1} << triples) - 1;
  const std::uint64_t middle = (std::uint64_t{1} << pairs) - 1;
  const std::uint64_t all_axes =
      spread_by_3(a & low) << 2 | spread_by_3(b & low) << 1 | spread_by_3(c);
  const std::uint64_t two_axes =
      spread_by_2(a >> triples & middle) << 1 | spread_by_2(b >> triples & middle);
  const std::uint64_t one_axis = a >> bits[1];
  return (one_axis << 2 * pairs | two_axes) << 3 * triples | all_axes;
}

/// Code of a doubled centroid.
std::uint64_t morton_code(const MortonGrid& grid, Vec3 centroid);

}  // namespace treelet
