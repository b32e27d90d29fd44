#include <treelet/primitive/morton.h>

#include <algorithm>
#include <cmath>

namespace treelet {
namespace {

/// A cell coordinate must fit spread_by_2, and float centroids have no more to tell apart.
constexpr int kMaxBitsPerAxis = 31;

/// Halvings that make extent `a` no longer than `b`, rounded down; as many as there can be if b =
/// 0.
int halvings(double a, double b) {
  if (b <= 0.0) return a > 0.0 ? kMaxBitsPerAxis : 0;
  return std::min(std::ilogb(a / b), kMaxBitsPerAxis);
}

std::array<std::uint8_t, 3> distribute_bits(double longest, double middle, double shortest) {
  const int behind_b = halvings(longest, middle);
  const int behind_c = std::max(behind_b, halvings(longest, shortest));
  for (int a = kMaxBitsPerAxis;; --a) {
    const int b = std::max(a - behind_b, 0), c = std::max(a - behind_c, 0);
    if (a + b + c <= kMortonBits && c <= 21) {
      return {std::uint8_t(a), std::uint8_t(b), std::uint8_t(c)};
    }
  }
}

std::uint64_t cell(const MortonGrid& grid, int rank, Vec3 centroid) {
  const double x = (double(centroid[grid.axis[rank]]) - grid.lower[rank]) * grid.scale[rank];
  const double last = double((std::uint64_t{1} << grid.bits[rank]) - 1);
  return std::uint64_t(std::clamp(x, 0.0, last));
}

}  // namespace

MortonGrid make_morton_grid(const Aabb& bounds) {
  MortonGrid grid;
  if (bounds.is_empty()) return grid;
  const Vec3 extent = bounds.extent();
  std::stable_sort(grid.axis.begin(), grid.axis.end(),
                   [&](int a, int b) { return extent[a] > extent[b]; });
  const auto& axis = grid.axis;
  grid.bits = distribute_bits(extent[axis[0]], extent[axis[1]], extent[axis[2]]);
  for (int rank = 0; rank < 3; ++rank) {
    const double length = 2.0 * extent[axis[rank]];
    grid.lower[rank] = 2.0 * bounds.lower[axis[rank]];
    grid.scale[rank] = length > 0.0 ? std::ldexp(1.0, grid.bits[rank]) / length : 0.0;
  }
  return grid;
}

std::uint64_t morton_code(const MortonGrid& grid, Vec3 centroid) {
  return interleave(grid.bits, cell(grid, 0, centroid), cell(grid, 1, centroid),
                    cell(grid, 2, centroid));
}

}  // namespace treelet
