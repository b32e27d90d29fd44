#include <treelet/primitive/morton.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <string>

#include "support/random.h"

namespace treelet {
namespace {

using test::Random;
using Bits = std::array<std::uint8_t, 3>;

TEST(SpreadBy3, MovesEachBitToItsPlaceAndDropsTheRest) {
  for (int bit = 0; bit < 64; ++bit) {
    const std::uint64_t expected = bit < 21 ? std::uint64_t{1} << 3 * bit : 0;
    EXPECT_EQ(spread_by_3(std::uint64_t{1} << bit), expected) << "bit " << bit;
  }
  EXPECT_EQ(spread_by_3(~std::uint64_t{0}), 0x1249249249249249u);
}

TEST(SpreadBy2, MovesEachBitToItsPlaceAndDropsTheRest) {
  for (int bit = 0; bit < 64; ++bit) {
    const std::uint64_t expected = bit < 32 ? std::uint64_t{1} << 2 * bit : 0;
    EXPECT_EQ(spread_by_2(std::uint64_t{1} << bit), expected) << "bit " << bit;
  }
  EXPECT_EQ(spread_by_2(~std::uint64_t{0}), 0x5555555555555555u);
}

/// Appends one bit at a time: an axis takes part as soon as no other has more bits left.
std::uint64_t interleave_bit_by_bit(const Bits& bits, const std::array<std::uint64_t, 3>& cell) {
  std::uint64_t code = 0;
  for (int level = bits[0] - 1; level >= 0; --level) {
    for (int axis = 0; axis < 3; ++axis) {
      if (level < bits[axis]) code = code << 1 | (cell[axis] >> level & 1);
    }
  }
  return code;
}

TEST(Interleave, AgreesWithBitByBitForAllDistributions) {
  constexpr std::uint64_t seed = 41;
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  int distributions = 0;
  for (int a = 0; a <= 31; ++a) {
    for (int b = 0; b <= a; ++b) {
      for (int c = 0; c <= std::min({b, 21, kMortonBits - a - b}); ++c) {
        const Bits bits{std::uint8_t(a), std::uint8_t(b), std::uint8_t(c)};
        const auto below_power = [&](int n) { return random.below(std::uint64_t{1} << n); };
        const std::array<std::uint64_t, 3> cell{below_power(a), below_power(b), below_power(c)};
        ASSERT_EQ(interleave(bits, cell[0], cell[1], cell[2]), interleave_bit_by_bit(bits, cell))
            << a << " " << b << " " << c << " bits";
        ++distributions;
      }
    }
  }
  EXPECT_GT(distributions, 1000);
}

TEST(Interleave, PutsTheLongestAxisFirst) {
  EXPECT_EQ(interleave({1, 1, 1}, 1, 0, 0), 0b100u);
  EXPECT_EQ(interleave({1, 1, 1}, 0, 1, 0), 0b010u);
  EXPECT_EQ(interleave({1, 1, 1}, 0, 0, 1), 0b001u);
  EXPECT_EQ(interleave({3, 2, 1}, 0b101, 0b01, 0b1), 0b100111u);
}

Aabb box_of_extent(float x, float y, float z) { return {{-1, 2, 3}, {-1 + x, 2 + y, 3 + z}}; }

void expect_sound_grid(const MortonGrid& grid, const Aabb& bounds) {
  const Vec3 extent = bounds.extent();
  EXPECT_LE(grid.bits[0] + grid.bits[1] + grid.bits[2], kMortonBits);
  EXPECT_LE(grid.bits[0], 31);
  EXPECT_LE(grid.bits[2], 21);  // what spread_by_3 takes
  EXPECT_EQ((1 << grid.axis[0]) + (1 << grid.axis[1]) + (1 << grid.axis[2]), 7);
  for (int rank = 1; rank < 3; ++rank) {
    EXPECT_GE(grid.bits[rank - 1], grid.bits[rank]);
    EXPECT_GE(extent[grid.axis[rank - 1]], extent[grid.axis[rank]]);
  }
}

TEST(MortonGrid, GivesACubeTheSameBitsOnEveryAxis) {
  const MortonGrid grid = make_morton_grid({{0, 0, 0}, {1, 1, 1}});
  EXPECT_EQ(grid.bits, (Bits{21, 21, 21}));
  EXPECT_EQ(grid.axis, (std::array<std::uint8_t, 3>{0, 1, 2}));
}

TEST(MortonGrid, GivesABitLessToAnAxisOfHalfTheLength) {
  const MortonGrid grid = make_morton_grid({{0, 0, 0}, {0.25f, 1, 0.5f}});
  EXPECT_EQ(grid.axis, (std::array<std::uint8_t, 3>{1, 2, 0}));
  EXPECT_EQ(grid.bits, (Bits{22, 21, 20}));
}

TEST(MortonGrid, SpendsNoBitsOnFlatAxes) {
  EXPECT_EQ(make_morton_grid({{0, 0, 0}, {1, 1, 0}}).bits, (Bits{31, 31, 0}));
  EXPECT_EQ(make_morton_grid({{0, 0, 0}, {0, 1, 0}}).bits, (Bits{31, 0, 0}));
}

TEST(MortonGrid, TakesPointsAndNothing) {
  const MortonGrid point = make_morton_grid({{1, 2, 3}, {1, 2, 3}});
  EXPECT_EQ(morton_code(point, {2, 4, 6}), 0u);
  EXPECT_EQ(make_morton_grid(Aabb::empty()).bits, (Bits{0, 0, 0}));
}

TEST(MortonGrid, IsSoundForBoxesOfAllShapes) {
  for (const float x : {0.0f, 1e-30f, 0.001f, 0.5f, 1.0f}) {
    for (const float y : {0.0f, 1e-30f, 0.007f, 0.9f, 1.0f}) {
      for (const float z : {0.0f, 1e-40f, 0.1f, 1.0f}) {
        const Aabb box{{0, 0, 0}, {x, y, z}};
        SCOPED_TRACE(std::to_string(x) + " x " + std::to_string(y) + " x " + std::to_string(z));
        expect_sound_grid(make_morton_grid(box), box);
      }
    }
  }
}

/// The grid as the standard library would make it.
MortonGrid grid_by_library(const Aabb& bounds) {
  MortonGrid grid;
  const Vec3 extent = bounds.extent();
  std::stable_sort(grid.axis.begin(), grid.axis.end(),
                   [&](int a, int b) { return extent[a] > extent[b]; });
  const auto halvings = [&](int rank) {
    const double longest = extent[grid.axis[0]], other = extent[grid.axis[rank]];
    if (other == 0.0) return longest > 0.0 ? 31 : 0;
    return std::min(std::ilogb(longest / other), 31);
  };
  const int behind[] = {0, halvings(1), halvings(2)};
  for (int most = 31;; --most) {
    int sum = 0;
    for (int rank = 0; rank < 3; ++rank) {
      grid.bits[rank] = std::uint8_t(std::max(most - behind[rank], 0));
      sum += grid.bits[rank];
    }
    if (sum <= kMortonBits && grid.bits[2] <= 21) break;
  }
  for (int rank = 0; rank < 3; ++rank) {
    const double length = 2.0 * extent[grid.axis[rank]];
    grid.lower[rank] = 2.0 * bounds.lower[grid.axis[rank]];
    grid.scale[rank] = length > 0.0 ? std::ldexp(1.0, grid.bits[rank]) / length : 0.0;
  }
  return grid;
}

TEST(MortonGrid, IsWhatTheStandardLibraryMakes) {
  constexpr std::uint64_t seed = 43;
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  const auto any_extent = [&] {
    if (random.below(6) == 0) return 0.0f;
    const int exponent = random.below(2) == 0 ? 0 : int(random.below(149));
    return std::ldexp(random.uniform(0.5f, 1.0f), -exponent);
  };
  for (int i = 0; i < 100'000; ++i) {
    const Vec3 extent{any_extent(), any_extent(), any_extent()};
    const Vec3 lower = random.below(2) == 0 ? Vec3{0, 0, 0} : random.point(-1.0f, 1.0f);
    const Aabb box{lower, lower + extent};
    const MortonGrid grid = make_morton_grid(box), expected = grid_by_library(box);
    ASSERT_EQ(grid.axis, expected.axis) << "box " << i;
    ASSERT_EQ(grid.bits, expected.bits) << "box " << i;
    ASSERT_EQ(grid.lower, expected.lower) << "box " << i;
    ASSERT_EQ(grid.scale, expected.scale) << "box " << i;
  }
}

// Near-cubic: the sides of a cell differ by less than a factor of four, unless bits run out.
TEST(MortonGrid, HasNearlyCubicCells) {
  constexpr std::uint64_t seed = 42;
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 extent = random.point(0.01f, 1.0f);
    const Aabb box = box_of_extent(extent.x, extent.y, extent.z);
    const MortonGrid grid = make_morton_grid(box);
    expect_sound_grid(grid, box);
    EXPECT_GE(grid.bits[0] + grid.bits[1] + grid.bits[2], kMortonBits - 2);
    for (const int rank : {1, 2}) {
      const double ratio = grid.scale[0] / grid.scale[rank];
      EXPECT_GT(ratio, 0.25);
      EXPECT_LT(ratio, 4.0);
    }
  }
}

TEST(MortonCode, RisesAlongEachAxisAndTheDiagonal) {
  const Aabb box = box_of_extent(4, 2, 1);
  const MortonGrid grid = make_morton_grid(box);
  const Vec3 extent = box.extent();
  for (const Vec3 way : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}, Vec3{1, 1, 1}}) {
    std::uint64_t before = 0;
    for (int i = 1; i <= 1000; ++i) {
      const float t = 2.0f * float(i) / 1000.0f;
      const Vec3 step{way.x * extent.x * t, way.y * extent.y * t, way.z * extent.z * t};
      const std::uint64_t code = morton_code(grid, box.lower * 2.0f + step);
      ASSERT_GT(code, before) << "step " << i;
      before = code;
    }
  }
}

TEST(MortonCode, OfTheCornersIsFirstAndLast) {
  for (const Aabb& box : {box_of_extent(4, 2, 1), box_of_extent(1, 1, 1), box_of_extent(3, 0, 1)}) {
    const MortonGrid grid = make_morton_grid(box);
    const int bits = grid.bits[0] + grid.bits[1] + grid.bits[2];
    EXPECT_EQ(morton_code(grid, box.lower * 2.0f), 0u);
    EXPECT_EQ(morton_code(grid, box.upper * 2.0f), (std::uint64_t{1} << bits) - 1);
  }
}

TEST(MortonCode, ClampsWhatLiesOutside) {
  const Aabb box = box_of_extent(1, 1, 1);
  const MortonGrid grid = make_morton_grid(box);
  EXPECT_EQ(morton_code(grid, {-100, -100, -100}), 0u);
  EXPECT_EQ(morton_code(grid, {100, 100, 100}), morton_code(grid, box.upper * 2.0f));
}

// The first bit of a code says which half of the longest axis the centroid is in.
TEST(MortonCode, HalvesTheLongestAxisFirst) {
  const Aabb box = box_of_extent(1, 4, 2);
  const MortonGrid grid = make_morton_grid(box);
  const std::uint64_t top = std::uint64_t{1} << (grid.bits[0] + grid.bits[1] + grid.bits[2] - 1);
  const Vec3 middle = box.lower + box.upper;
  EXPECT_EQ(morton_code(grid, middle + Vec3{0.9f, -0.1f, 1.9f}) & top, 0u);
  EXPECT_EQ(morton_code(grid, middle + Vec3{-0.9f, 0.1f, -1.9f}) & top, top);
}

}  // namespace
}  // namespace treelet
