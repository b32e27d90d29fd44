#include <treelet/primitive/split_steps.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "support/big_integer.h"
#include "support/meshes.h"
#include "support/random.h"

namespace treelet {
namespace {

using test::BigInteger;

/// As a multiple of 2^-300: exact for doubles that are floats or near them.
BigInteger exact(double x) { return BigInteger::from_scaled(x, 300); }

TEST(SplitRounding, BracketsByTwoUlpsAtMost) {
  test::Random random(1);
  for (int i = 0; i < 200000; ++i) {
    const int exponent = int(random.below(300)) - 170;
    const double x = std::ldexp(double(std::int64_t(random.bits())) * 0x1p-63, exponent);
    const float down = round_down(x), up = round_up(x);
    ASSERT_LE(double(down), x) << "seed 1, case " << i;
    ASSERT_GE(double(up), x) << "seed 1, case " << i;
    float two_below = std::nextafter(std::nextafter(float(x), -INFINITY), -INFINITY);
    ASSERT_GE(down, std::nextafter(two_below, -INFINITY)) << "seed 1, case " << i;
    ASSERT_EQ(up, -round_down(-x));
  }
}

TEST(SplitRounding, KeepsFloats) {
  for (const float x : {0.0f, 1.0f, -0.3f, 1e-45f, -1e-45f, 3e38f, -3e38f, 1e-40f}) {
    EXPECT_EQ(round_down(x), x);
    EXPECT_EQ(round_up(x), x);
  }
  EXPECT_FALSE(std::signbit(round_down(0.0)));
  EXPECT_FALSE(std::signbit(round_up(0.0)));
}

TEST(SplitRounding, StaysOnItsSideBeyondTheFloats) {
  constexpr float largest = std::numeric_limits<float>::max(), inf = INFINITY;
  EXPECT_EQ(round_down(1e39), largest);
  EXPECT_EQ(round_up(1e39), inf);
  EXPECT_EQ(round_down(-1e39), -inf);
  EXPECT_EQ(round_up(-1e39), -largest);
}

Triangle random_triangle(test::Random& random) {
  const float size = std::ldexp(1.0f, -int(random.below(30)));
  const Vec3 p = random.point(-1.0f, 1.0f);
  const auto vertex = [&] {
    Vec3 v = p + random.point(-size, size);
    if (random.below(4) == 0) v.y = p.y;
    if (random.below(4) == 0) v.z = p.z;
    return v;
  };
  return {vertex(), vertex(), vertex()};
}

/// Whether box contains the point where the edge from a to b crosses the plane, without rounding.
bool contains_crossing(const Aabb& box, Vec3 a, Vec3 b, int axis, float position) {
  if (a[axis] > b[axis]) std::swap(a, b);
  const BigInteger rise = exact(b[axis]) - exact(a[axis]), step = exact(position) - exact(a[axis]);
  for (int i = 0; i < 3; ++i) {
    const BigInteger at = exact(a[i]) * rise + step * (exact(b[i]) - exact(a[i]));
    if ((at - exact(box.lower[i]) * rise).sign() < 0) return false;
    if ((exact(box.upper[i]) * rise - at).sign() < 0) return false;
  }
  return true;
}

TEST(ClipAtPlane, BoxesHoldTheCornersOfBothSidesExactly) {
  test::Random random(2);
  for (int i = 0; i < 800; ++i) {
    const Triangle t = random_triangle(random);
    const Aabb whole = bounds(t);
    const int axis = int(random.below(3));
    const float position = random.uniform(whole.lower[axis], whole.upper[axis]);
    const SplitBoxes half = clip_at_plane(ExactTriangle(t, 1.0), axis, position);
    const std::array corners{t.p0, t.p1, t.p2};
    for (std::size_t c = 0; c < 3; ++c) {
      const Vec3 p = corners[c], q = corners[(c + 1) % 3];
      ASSERT_TRUE(p[axis] > position || half.below.contains({p, p})) << "seed 2, case " << i;
      ASSERT_TRUE(p[axis] < position || half.above.contains({p, p})) << "seed 2, case " << i;
      if ((p[axis] < position) == (q[axis] < position)) continue;
      if (p[axis] == position || q[axis] == position) continue;
      ASSERT_TRUE(contains_crossing(half.below, p, q, axis, position)) << "seed 2, case " << i;
      ASSERT_TRUE(contains_crossing(half.above, p, q, axis, position)) << "seed 2, case " << i;
    }
    ASSERT_TRUE(whole.contains(overlap(half.below, whole)));
    ASSERT_TRUE(!is_nonempty(half.below) || half.below.upper[axis] <= position);
    ASSERT_TRUE(!is_nonempty(half.above) || half.above.lower[axis] >= position);
  }
}

TEST(ClipAtPlane, IsTight) {
  const Triangle t{{0, 0, 0}, {4, 0, 2}, {0, 4, 0}};
  const SplitBoxes half = clip_at_plane(ExactTriangle(t, 1.0), 0, 1.0);
  const Aabb below{{0, 0, 0}, {1, 4, 0.5f}}, above{{1, 0, 0.5f}, {4, 3, 2}};
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(half.below.lower[axis], below.lower[axis], 1e-6);
    EXPECT_NEAR(half.below.upper[axis], below.upper[axis], 1e-6);
    EXPECT_NEAR(half.above.lower[axis], above.lower[axis], 1e-6);
    EXPECT_NEAR(half.above.upper[axis], above.upper[axis], 1e-6);
  }
}

/// The definition: of all planes of the grid well inside the box, those that the Morton code
/// tells apart by its highest bit.
int most_important_bit(const MortonGrid& grid, const Aabb& box) {
  int best = -1;
  for (int rank = 0; rank < 3; ++rank) {
    const GridAxis axis{grid, rank};
    for (int bit = 0; bit < grid.bits[rank]; ++bit) {
      const std::uint64_t step = std::uint64_t{1} << bit;
      for (std::uint64_t i = step; i < std::uint64_t{1} << grid.bits[rank]; i += 2 * step) {
        const float x = axis.plane_at(i, bit).position;
        const int a = grid.axis[rank];
        const float margin = kSplitMargin * (box.upper[a] - box.lower[a]);
        const bool is_inside = box.lower[a] + margin < x && x < box.upper[a] - margin;
        if (is_inside) best = std::max(best, axis.code_bit(bit));
      }
    }
  }
  return best;
}

/// A coarse one, so that all of its planes can be listed.
MortonGrid coarse_grid() {
  MortonGrid grid = make_morton_grid({{-1, 0, 0}, {3, 1, 2}});
  for (int rank = 0; rank < 3; ++rank) {
    grid.scale[rank] = std::ldexp(grid.scale[rank], -(grid.bits[2] - 3));
    grid.bits[rank] = std::uint8_t(grid.bits[rank] - (grid.bits[2] - 3));
  }
  return grid;
}

TEST(GridPlane, IsTheMostImportantInsideTheBox) {
  const MortonGrid grid = coarse_grid();
  test::Random random(3);
  int found = 0;
  for (int i = 0; i < 20000; ++i) {
    // Sides often lie on planes of the grid.
    const auto coordinate = [&](float x) { return random.below(2) ? x : std::round(x * 8) / 8; };
    const auto between = [&](Vec3 a, Vec3 b) {
      return Vec3{coordinate(random.uniform(a.x, b.x)), coordinate(random.uniform(a.y, b.y)),
                  coordinate(random.uniform(a.z, b.z))};
    };
    const Vec3 a = between({-1, 0, 0}, {3, 1, 2}), b = between({-1, 0, 0}, {3, 1, 2});
    const Aabb box{min(a, b), max(a, b)};
    const SplitPlane plane = find_grid_plane(grid, box);
    ASSERT_EQ(plane.importance, most_important_bit(grid, box)) << "seed 3, case " << i;
    if (!plane.exists()) continue;
    ++found;
    ASSERT_LT(box.lower[plane.axis], plane.position);
    ASSERT_GT(box.upper[plane.axis], plane.position);
    ASSERT_LE(plane.level, 0);
  }
  EXPECT_GT(found, 10000);
  EXPECT_LT(found, 20000);
}

TEST(GridPlane, CodeBitsAreThoseOfInterleave) {
  for (const Aabb& box : {Aabb{{0, 0, 0}, {8, 2, 1}}, Aabb{{0, 0, 0}, {1, 1, 1}},
                          Aabb{{0, 0, 0}, {1, 5, 0}}, Aabb{{0, 0, 0}, {0, 0, 3}}}) {
    const MortonGrid grid = make_morton_grid(box);
    for (int rank = 0; rank < 3; ++rank) {
      for (int bit = 0; bit < grid.bits[rank]; ++bit) {
        std::array<std::uint64_t, 3> cell{};
        cell[std::size_t(rank)] = std::uint64_t{1} << bit;
        const std::uint64_t code = interleave(grid.bits, cell[0], cell[1], cell[2]);
        const GridAxis axis{grid, rank};
        EXPECT_EQ(code, std::uint64_t{1} << axis.code_bit(bit));
      }
    }
  }
}

TEST(SplitPriority, IsNeverNegativeNorNan) {
  const MortonGrid grid = make_morton_grid({{-1, -1, -1}, {1, 1, 1}});
  test::Random random(4);
  for (int i = 0; i < 100000; ++i) {
    const ExactTriangle t(random_triangle(random), 1.0);
    const float priority = split_priority(grid, t, t.bounds());
    ASSERT_GE(priority, 0.0f) << "seed 4, case " << i;
    ASSERT_LT(priority, 2.0f) << "seed 4, case " << i;
  }
}

TEST(SplitPriority, OfBoxesThatOverflowedIsZero) {
  const MortonGrid grid = make_morton_grid({{-1, -1, -1}, {1, 1, 1}});
  const ExactTriangle t({{-1e30f, 0, 0}, {1e30f, 1e30f, 0}, {0, -1e30f, 1e30f}}, 1.0);
  EXPECT_EQ(split_priority(grid, t, t.bounds()), 0.0f);
  const ExactTriangle beyond({{0, 0, 1e10f}, {1, 1, 1e10f}, {1, 0, 1e10f}}, 0x1p120);
  EXPECT_EQ(split_priority(grid, beyond, beyond.bounds()), 0.0f);
}

TEST(SplitPriority, PrefersWasteAndImportantPlanes) {
  const MortonGrid grid = make_morton_grid({{0, 0, 0}, {1, 1, 1}});
  const auto priority = [&](const Triangle& triangle) {
    const ExactTriangle t(triangle, 1.0);
    return split_priority(grid, t, t.bounds());
  };
  const float across_the_middle =
      priority({{0.4f, 0.4f, 0.4f}, {0.6f, 0.6f, 0.6f}, {0.41f, 0.4f, 0.4f}});
  const float beside =
      priority({{0.28f, 0.28f, 0.28f}, {0.48f, 0.48f, 0.48f}, {0.29f, 0.28f, 0.28f}});
  const float filled = priority({{0.4f, 0.4f, 0.5f}, {0.6f, 0.4f, 0.5f}, {0.4f, 0.6f, 0.5f}});
  EXPECT_GT(across_the_middle, beside);
  EXPECT_GT(across_the_middle, filled);
  EXPECT_GT(beside, 0.0f);
}

TEST(FactorSearch, FindsTheLargestThatFits) {
  test::Random random(5);
  for (int run = 0; run < 200; ++run) {
    std::vector<float> priorities(1 + random.below(300));
    for (float& p : priorities) p = random.below(5) == 0 ? 0.0f : random.uniform(0.0f, 1.5f);
    const float largest = *std::max_element(priorities.begin(), priorities.end());
    const std::uint64_t budget = random.below(1000);
    const auto splits = [&](float factor) {
      std::uint64_t sum = 0;
      for (const float p : priorities) sum += split_count(factor, p);
      return sum;
    };
    FactorSearch search(largest, budget);
    for (int i = 0; i < FactorSearch::kRounds; ++i) search.learn(splits(search.candidate()));
    ASSERT_LE(splits(search.factor()), budget) << "seed 5, run " << run;
    if (largest > 0.0f) {
      ASSERT_GT(splits(search.factor() * 1.001f), budget) << "seed 5, run " << run;
    } else {
      ASSERT_EQ(search.factor(), 0.0f);
    }
  }
}

/// Points of the triangle in 1/64ths of its barycentric coordinates, compared without rounding.
void expect_covered(const ExactTriangle& t, const std::vector<Reference>& pieces,
                    const std::string& name) {
  constexpr int kSteps = 64;
  for (int u = 0; u <= kSteps; u += 8) {
    for (int v = 0; u + v <= kSteps; v += 7) {
      BigInteger point[3];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        point[axis] = exact(t.vertex[0][axis]) * exact(kSteps - u - v) +
                      exact(t.vertex[1][axis]) * exact(u) + exact(t.vertex[2][axis]) * exact(v);
      }
      const auto is_inside = [&](const Reference& piece) {
        for (int axis = 0; axis < 3; ++axis) {
          if ((point[axis] - exact(piece.lower[axis]) * exact(kSteps)).sign() < 0) return false;
          if ((exact(piece.upper[axis]) * exact(kSteps) - point[axis]).sign() < 0) return false;
        }
        return true;
      };
      ASSERT_TRUE(std::any_of(pieces.begin(), pieces.end(), is_inside)) << name << u << " " << v;
    }
  }
}

TEST(SplitTriangle, PiecesFillTheirPlacesAndCoverTheTriangle) {
  const MortonGrid grid = make_morton_grid({{-1, -1, -1}, {1, 1, 1}});
  test::Random random(6);
  for (int i = 0; i < 20; ++i) {
    const std::string name = "seed 6, case " + std::to_string(i) + ": ";
    const ExactTriangle t(random_triangle(random), 0.5);
    const auto splits = std::uint32_t(random.below(40));
    std::vector<Reference> pieces(splits + 1);
    split_triangle(grid, t, 77, splits, pieces.data());
    for (const Reference& piece : pieces) {
      ASSERT_EQ(piece.face, 77u);
      ASSERT_EQ(piece.padding, 0u);
      ASSERT_TRUE(is_nonempty(piece.box()));
      ASSERT_TRUE(t.bounds().contains(piece.box())) << name;
    }
    expect_covered(t, pieces, name);
  }
}

TEST(SplitTriangle, PiecesLieInTheBoxOfThePieceTheyCameFrom) {
  const MortonGrid grid = make_morton_grid({{-1, -1, -1}, {1, 1, 1}});
  test::Random random(7);
  for (int i = 0; i < 2000; ++i) {
    const ExactTriangle t(random_triangle(random), 1.0);
    const Aabb box = t.bounds();
    if (max_component(box.extent()) < 1e-5f) continue;  // may be too small to split
    std::array<Reference, 3> places{};
    places[0] = {box.lower, 5, box.upper, 2};
    split_piece(grid, t, places.data());
    const std::uint32_t second = places[0].padding + 1;
    ASSERT_LE(second, 2u);
    ASSERT_EQ(places[0].padding + places[second].padding, 1u) << "seed 7, case " << i;
    ASSERT_TRUE(box.contains(places[0].box()) && box.contains(places[second].box()));
  }
}

TEST(SplitTriangle, EachPlaceCanBeFilledOnItsOwn) {
  const MortonGrid grid = make_morton_grid({{-1, -1, -1}, {1, 1, 1}});
  test::Random random(8);
  for (int i = 0; i < 500; ++i) {
    const double scale = i % 2 == 0 ? 0.5 : 0x1p-40;  // too small for the grid
    const ExactTriangle t(random_triangle(random), scale);
    const auto splits = std::uint32_t(random.below(i % 50 == 0 ? 2000 : 40));
    std::vector<Reference> pieces(splits + 1);
    split_triangle(grid, t, 0, splits, pieces.data());
    for (std::uint32_t place = 0; place <= splits; ++place) {
      ASSERT_EQ(find_piece(grid, t, splits, place), pieces[place].box())
          << "seed 8, case " << i << ", place " << place;
    }
  }
}

TEST(SplitTriangle, FewerTheSurfaceOfItsBoxes) {
  const MortonGrid grid = make_morton_grid({{0, 0, 0}, {1, 1, 1}});
  const ExactTriangle sliver({{0.1f, 0.1f, 0.1f}, {0.9f, 0.9f, 0.9f}, {0.9f, 0.9f, 0.89f}}, 1.0);
  std::vector<Reference> pieces(64);
  split_triangle(grid, sliver, 0, 63, pieces.data());
  float sum = 0.0f;
  for (const Reference& piece : pieces) sum += half_area(piece.box());
  EXPECT_LT(sum, half_area(sliver.bounds()) / 25.0f);
}

TEST(SplitTriangle, TooSmallToSplitBecomesCopies) {
  const MortonGrid grid = make_morton_grid({{0, 0, 0}, {1, 1, 1}});
  const float next = std::nextafter(0.3f, 1.0f);
  const ExactTriangle t({{0.3f, 0.3f, 0.3f}, {next, 0.3f, 0.3f}, {0.3f, next, 0.3f}}, 1.0);
  std::vector<Reference> pieces(200);
  split_triangle(grid, t, 0, 199, pieces.data());
  for (const Reference& piece : pieces) EXPECT_EQ(piece.box(), t.bounds());
}

}  // namespace
}  // namespace treelet
