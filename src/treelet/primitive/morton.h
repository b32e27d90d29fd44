#pragma once

#include <array>
#include <cstdint>

#include <treelet/core/aabb.h>
#include <treelet/primitive/power_of_two.h>

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

/// A cell coordinate must fit spread_by_2, and float centroids have no more to tell apart.
constexpr int kMaxBitsPerAxis = 31;
/// What spread_by_3 takes.
constexpr int kMaxBitsOfShortestAxis = 21;

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

namespace detail {

/// Axes by falling extent; of equal ones the first stays first.
TREELET_HD constexpr std::array<std::uint8_t, 3> order_axes(Vec3 extent) {
  std::array<std::uint8_t, 3> axis{0, 1, 2};
  for (const int rank : {0, 1, 0}) {
    const std::uint8_t a = axis[rank], b = axis[rank + 1];
    if (!(extent[b] > extent[a])) continue;
    axis[rank] = b;
    axis[rank + 1] = a;
  }
  return axis;
}

/// Halvings that make extent `a` no longer than `b`, rounded down; where b is 0, as many as there
/// can be.
TREELET_HD constexpr int halvings(double a, double b) {
  if (b <= 0.0) return a > 0.0 ? kMaxBitsPerAxis : 0;
  const int count = floor_log2(a / b);
  return count < kMaxBitsPerAxis ? count : kMaxBitsPerAxis;
}

TREELET_HD constexpr std::array<std::uint8_t, 3> distribute_bits(double longest, double middle,
                                                                 double shortest) {
  const int behind_b = halvings(longest, middle);
  const int behind_c = halvings(longest, shortest);  // not less: a quotient rounds monotonically
  int a = kMaxBitsPerAxis, b = 0, c = 0;
  for (;; --a) {
    b = a > behind_b ? a - behind_b : 0;
    c = a > behind_c ? a - behind_c : 0;
    if (a + b + c <= kMortonBits && c <= kMaxBitsOfShortestAxis) break;
  }
  return {std::uint8_t(a), std::uint8_t(b), std::uint8_t(c)};
}

TREELET_HD constexpr std::uint64_t cell(const MortonGrid& grid, int rank, Vec3 centroid) {
  const double x = (double(centroid[grid.axis[rank]]) - grid.lower[rank]) * grid.scale[rank];
  const double last = double((std::uint64_t{1} << grid.bits[rank]) - 1);
  return std::uint64_t(x < 0.0 ? 0.0 : last < x ? last : x);
}

}  // namespace detail

/// For doubled centroids of boxes inside `bounds`.
TREELET_HD constexpr MortonGrid make_morton_grid(const Aabb& bounds) {
  MortonGrid grid;
  if (bounds.is_empty()) return grid;
  const Vec3 extent = bounds.extent();
  grid.axis = detail::order_axes(extent);
  const auto& axis = grid.axis;
  grid.bits = detail::distribute_bits(extent[axis[0]], extent[axis[1]], extent[axis[2]]);
  for (int rank = 0; rank < 3; ++rank) {
    const double length = 2.0 * extent[axis[rank]];
    grid.lower[rank] = 2.0 * bounds.lower[axis[rank]];
    grid.scale[rank] = length > 0.0 ? power_of_two(grid.bits[rank]) / length : 0.0;
  }
  return grid;
}

/// Code of a doubled centroid.
TREELET_HD constexpr std::uint64_t morton_code(const MortonGrid& grid, Vec3 centroid) {
  return interleave(grid.bits, detail::cell(grid, 0, centroid), detail::cell(grid, 1, centroid),
                    detail::cell(grid, 2, centroid));
}

}  // namespace treelet
