#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include <treelet/core/aabb.h>
#include <treelet/core/bits.h>
#include <treelet/mesh/mesh.h>
#include <treelet/primitive/morton.h>
#include <treelet/primitive/power_of_two.h>
#include <treelet/primitive/reference.h>

// What splitting does with one triangle and with one piece of it [KarrasAila2013 s4]; host and
// device loop over it.
//
// The pieces of a triangle cover it: each of its points lies in the box of a piece. For it lies in
// the box of the whole triangle, and where it lies in a box that is split, it lies on one side of
// the plane at least, thus in the box of what that side leaves of the whole triangle, which is
// rounded outwards, thus in the overlap of that with the box that was split.

namespace treelet {

// A double to the nearest float that is not above or not below it, or to a neighbour of that.
TREELET_HD constexpr double magnitude(double x) { return x < 0.0 ? -x : x; }
TREELET_HD constexpr float round_down(double x) {
  constexpr float largest = std::numeric_limits<float>::max();
  if (x > largest) return largest;
  const float nearest = float(x);
  return double(nearest) <= x ? nearest : float(x - (magnitude(x) * 0x1p-23 + 0x1p-149));
}
TREELET_HD constexpr float round_up(double x) { return -round_down(-x); }

/// A box in double, which grows.
struct ExactBox {
  std::array<double, 3> lower, upper;

  TREELET_HD static constexpr ExactBox empty() {
    constexpr double inf = std::numeric_limits<double>::infinity();
    return {{inf, inf, inf}, {-inf, -inf, -inf}};
  }
  TREELET_HD constexpr void add(int axis, double from, double to) {
    if (from < lower[axis]) lower[axis] = from;
    if (to > upper[axis]) upper[axis] = to;
  }
  TREELET_HD constexpr Aabb rounded_outwards() const {
    return {{round_down(lower[0]), round_down(lower[1]), round_down(lower[2])},
            {round_up(upper[0]), round_up(upper[1]), round_up(upper[2])}};
  }
};

/// A triangle in build space. Doubles hold a float times any power of two that scales a mesh. On an
/// axis where it reaches beyond the limit all of the mesh has one coordinate, so that it keeps its
/// shape.
struct ExactTriangle {
  std::array<std::array<double, 3>, 3> vertex;

  TREELET_HD ExactTriangle(const Triangle& t, double scale)
      : vertex{scaled(t.p0, scale), scaled(t.p1, scale), scaled(t.p2, scale)} {}

  TREELET_HD Aabb bounds() const {
    ExactBox box = ExactBox::empty();
    for (const auto& p : vertex) {
      for (int axis = 0; axis < 3; ++axis) box.add(axis, p[axis], p[axis]);
    }
    return box.rounded_outwards();
  }

 private:
  TREELET_HD static std::array<double, 3> scaled(Vec3 p, double scale) {
    return {limited(p.x * scale), limited(p.y * scale), limited(p.z * scale)};
  }
  TREELET_HD static constexpr double limited(double x) {
    constexpr double limit = kBuildSpaceLimit;
    return (x < -limit ? -limit : limit < x ? limit : x) + 0.0;  // -0 to +0
  }
};

TREELET_HD constexpr Aabb overlap(const Aabb& a, const Aabb& b) {
  return {max(a.lower, b.lower), min(a.upper, b.upper)};
}
TREELET_HD constexpr bool is_nonempty(const Aabb& box) {
  return box.lower.x <= box.upper.x && box.lower.y <= box.upper.y && box.lower.z <= box.upper.z;
}

/// What lies on the two sides of a plane.
struct SplitBoxes {
  Aabb below, above;
};

/// Adds where the edge from p to q, p below the plane and q above, meets the plane. Of a result
/// p + s (q - p), with differences, quotient, product and sum rounded, the error is below
/// 6 * 2^-53 |q - p| + 2^-53 |result|; the point is on the edge, which bounds it as well.
TREELET_HD inline void add_crossing(const std::array<double, 3>& p, const std::array<double, 3>& q,
                                    int axis, double position, ExactBox& below, ExactBox& above) {
  const double s = (position - p[axis]) / (q[axis] - p[axis]);
  for (int i = 0; i < 3; ++i) {
    double from = position, to = position;
    if (i != axis) {
      const double extent = q[i] - p[i], x = p[i] + s * extent;
      const double error = magnitude(extent) * 0x1p-50 + magnitude(x) * 0x1p-52;
      const double least = extent < 0.0 ? q[i] : p[i], most = extent < 0.0 ? p[i] : q[i];
      from = x - error > least ? x - error : least;
      to = x + error < most ? x + error : most;
    }
    below.add(i, from, to);
    above.add(i, from, to);
  }
}

/// Boxes of what a plane leaves of a triangle on each side, the plane included.
TREELET_HD inline SplitBoxes clip_at_plane(const ExactTriangle& triangle, int axis,
                                           double position) {
  ExactBox below = ExactBox::empty(), above = ExactBox::empty();
  for (int i = 0; i < 3; ++i) {
    const auto& p = triangle.vertex[i];
    const auto& q = triangle.vertex[i == 2 ? 0 : i + 1];
    for (int j = 0; j < 3; ++j) {
      if (p[axis] <= position) below.add(j, p[j], p[j]);
      if (p[axis] >= position) above.add(j, p[j], p[j]);
    }
    if (p[axis] < position && q[axis] > position) add_crossing(p, q, axis, position, below, above);
    if (q[axis] < position && p[axis] > position) add_crossing(q, p, axis, position, below, above);
  }
  return {below.rounded_outwards(), above.rounded_outwards()};
}

/// Where a box is cut.
struct SplitPlane {
  int axis = -1;  ///< -1: nowhere
  float position = 0.0f;
  int level = 0;        ///< halvings of the scene's longest side down to such planes, negated
  int importance = -1;  ///< bit of the Morton code that tells its sides apart

  TREELET_HD constexpr bool exists() const { return axis >= 0; }
};

/// One axis of the Morton grid, by its rank. Boundary i lies below cell i.
struct GridAxis {
  const MortonGrid& grid;
  int rank;

  /// Up to the boundary behind the last cell.
  TREELET_HD constexpr std::uint64_t cell_of(float x) const {
    const double cell = (2.0 * x - grid.lower[rank]) * grid.scale[rank];
    const double count = power_of_two(grid.bits[rank]);
    return std::uint64_t(cell < 0.0 ? 0.0 : cell < count ? cell : count);
  }

  TREELET_HD constexpr SplitPlane plane_at(std::uint64_t boundary, int bit) const {
    const double position = 0.5 * (grid.lower[rank] + double(boundary) / grid.scale[rank]);
    return {grid.axis[rank], float(position), bit + 1 - grid.bits[0], code_bit(bit)};
  }

  /// The bit of a Morton code that holds this bit of the axis; see interleave().
  TREELET_HD constexpr int code_bit(int bit) const {
    const int triples = grid.bits[2], pairs = grid.bits[1] - grid.bits[2];
    if (bit < triples) return 3 * bit + 2 - rank;
    if (bit < grid.bits[1]) return 3 * triples + 2 * (bit - triples) + 1 - rank;
    return 3 * triples + 2 * pairs + bit - grid.bits[1];
  }

  /// The most important boundary between two cells that differ.
  TREELET_HD constexpr SplitPlane plane_between(std::uint64_t first, std::uint64_t last) const {
    const int bit = 63 - count_leading_zeros(first ^ last);
    return plane_at(last >> bit << bit, bit);
  }
};

/// A plane so near to the side of a box, in shares of its extent, would cut off next to nothing.
/// Differs from [KarrasAila2013 s4.2]: without it the split of a diagonal in x is followed by one
/// in y at nearly the same place.
inline constexpr float kSplitMargin = 1.0f / 32;

/// The most important plane across the inside of a box, along one axis of the grid.
TREELET_HD constexpr SplitPlane find_grid_plane(const GridAxis& grid, const Aabb& box) {
  const int axis = grid.grid.axis[grid.rank];
  const float margin = kSplitMargin * (box.upper[axis] - box.lower[axis]);
  const float lower = box.lower[axis] + margin, upper = box.upper[axis] - margin;
  if (!(lower < upper)) return {};
  const std::uint64_t first = grid.cell_of(lower), last = grid.cell_of(upper);
  if (first == last) return {};
  SplitPlane plane = grid.plane_between(first, last);
  if (plane.position >= upper && last - 1 > first) {  // it ends at that plane
    plane = grid.plane_between(first, last - 1);
  }
  return lower < plane.position && plane.position < upper ? plane : SplitPlane{};
}

/// Differs from [KarrasAila2013 s4.1] in what a level is, as bits of our grid go to axes by extent:
/// halvings of the longest side, so that planes of one level bound cells of one size.
TREELET_HD constexpr SplitPlane find_grid_plane(const MortonGrid& grid, const Aabb& box) {
  SplitPlane best;
  for (int rank = 0; rank < 3; ++rank) {
    const SplitPlane plane = find_grid_plane(GridAxis{grid, rank}, box);
    if (plane.importance > best.importance) best = plane;
  }
  return best;
}

TREELET_HD constexpr int longest_axis(const Aabb& box) {
  const Vec3 extent = box.extent();
  if (extent.x >= extent.y && extent.x >= extent.z) return 0;
  return extent.y >= extent.z ? 1 : 2;
}

/// The grid's plane, or the middle of the longest side where the grid is too coarse.
TREELET_HD inline SplitPlane find_split_plane(const MortonGrid& grid, const Aabb& box) {
  const SplitPlane plane = find_grid_plane(grid, box);
  if (plane.exists()) return plane;
  const int axis = longest_axis(box);
  const float middle = box.lower[axis] + 0.5f * (box.upper[axis] - box.lower[axis]);
  const bool is_inside = box.lower[axis] < middle && middle < box.upper[axis];
  return is_inside ? SplitPlane{axis, middle, 0, 0} : SplitPlane{};
}

/// Twice the area of a triangle's three projections: the least surface that boxes around ever
/// smaller pieces can have.
TREELET_HD inline float ideal_area(const ExactTriangle& t) {
  double a[3], b[3], sum = 0.0;
  for (int i = 0; i < 3; ++i) {
    a[i] = t.vertex[1][i] - t.vertex[0][i];
    b[i] = t.vertex[2][i] - t.vertex[0][i];
  }
  for (int i = 0; i < 3; ++i) {
    const int next = i == 2 ? 0 : i + 1, after = 3 - i - next;
    sum += magnitude(a[next] * b[after] - a[after] * b[next]);
  }
  return float(sum);
}

/// How much splitting a triangle promises [KarrasAila2013 s4.1]: the surface that its box has too
/// much, weighted by how high in the tree the plane lies that it straddles. Differs: the fourth
/// root instead of the third. It leaves less to the few largest triangles, gives better trees on
/// nearly all scenes, and two square roots are the same bits everywhere.
TREELET_HD inline float split_priority(const MortonGrid& grid, const ExactTriangle& triangle,
                                       const Aabb& box) {
  const SplitPlane plane = find_grid_plane(grid, box);
  if (!plane.exists()) return 0.0f;
  const float waste = 2.0f * half_area(box) - ideal_area(triangle);
  // Rounding makes it negative. Areas in build space are below 6, unless coordinates overflowed.
  if (!(waste > 0.0f && waste < 8.0f)) return 0.0f;
  return std::sqrt(std::sqrt(waste * float_power_of_two(plane.level)));
}

/// Splits of a triangle when the whole budget is shared out by `factor`.
TREELET_HD constexpr std::uint32_t split_count(float factor, float priority) {
  constexpr float kMost = 0x1p30f;
  const float splits = factor * priority;
  return std::uint32_t(splits < kMost ? splits : kMost);
}

/// Bisection for the largest factor whose splits fit into the budget, over the bits of positive
/// floats, which are in the order of the floats.
struct FactorSearch {
  static constexpr int kRounds = 20;  ///< leave less than 1e-4 of the factor open

  std::uint32_t fits = 0, exceeds = 0;
  std::uint64_t budget;

  /// With the largest priority: half a split fits, and one triangle alone can exceed the budget.
  TREELET_HD constexpr FactorSearch(float largest, std::uint64_t most_splits)
      : budget(most_splits) {
    if (!(largest > 0.0f)) return;
    fits = std::bit_cast<std::uint32_t>(0.5f / largest);
    exceeds = std::bit_cast<std::uint32_t>((float(budget) + 2.0f) / largest);
  }

  TREELET_HD constexpr std::uint32_t middle() const { return fits + (exceeds - fits) / 2; }
  TREELET_HD constexpr float candidate() const { return std::bit_cast<float>(middle()); }
  TREELET_HD constexpr void learn(std::uint64_t splits_of_candidate) {
    (splits_of_candidate <= budget ? fits : exceeds) = middle();
  }
  TREELET_HD constexpr float factor() const { return std::bit_cast<float>(fits); }
};

/// What a plane leaves of a piece, which is the part of a triangle inside its box, on both sides;
/// or nothing, if no plane splits it. Where a plane leaves one side empty, the box had room to
/// spare: it shrinks, and the next plane is tried.
TREELET_HD inline SplitBoxes split_box(const MortonGrid& grid, const ExactTriangle& triangle,
                                       Aabb& box) {
  for (;;) {
    const SplitPlane plane = find_split_plane(grid, box);
    if (!plane.exists()) return {Aabb::empty(), Aabb::empty()};
    const SplitBoxes whole = clip_at_plane(triangle, plane.axis, plane.position);
    const SplitBoxes half{overlap(whole.below, box), overlap(whole.above, box)};
    const bool has_below = is_nonempty(half.below), has_above = is_nonempty(half.above);
    if (has_below && has_above) return half;
    if (!has_below && !has_above) return {Aabb::empty(), Aabb::empty()};
    box = has_below ? half.below : half.above;
  }
}

/// Splits for the lower half of those that are left, by longest side [KarrasAila2013 s4.2].
TREELET_HD constexpr std::uint32_t share_splits(std::uint32_t splits, const SplitBoxes& half) {
  const float a = max_component(half.below.extent()), b = max_component(half.above.extent());
  const float share = a + b > 0.0f ? a / (a + b) : 0.5f;
  const std::uint32_t below = std::uint32_t(float(splits) * share + 0.5f);
  return below < splits ? below : splits;
}

/// Splits one piece. A piece with k splits to go, kept in its padding, owns k + 1 places and lies
/// in the first; its halves share the places, so that pieces need no stack and can be split in any
/// order. A piece that cannot be split fills its places with copies.
TREELET_HD inline void split_piece(const MortonGrid& grid, const ExactTriangle& triangle,
                                   Reference* piece) {
  const std::uint32_t splits = piece->padding, face = piece->face;
  Aabb box = piece->box();
  const SplitBoxes half = split_box(grid, triangle, box);
  const auto write = [&](std::uint32_t place, const Aabb& part, std::uint32_t splits_left) {
    piece[place] = {part.lower, face, part.upper, splits_left};
  };
  if (is_nonempty(half.below)) {
    const std::uint32_t below = share_splits(splits - 1, half);
    write(0, half.below, below);
    write(below + 1, half.above, splits - 1 - below);
  } else {
    for (std::uint32_t place = 0; place <= splits; ++place) write(place, box, 0);
  }
}

/// Splits a triangle to the end, into `splits` + 1 places.
TREELET_HD inline void split_triangle(const MortonGrid& grid, const ExactTriangle& triangle,
                                      std::uint32_t face, std::uint32_t splits, Reference* places) {
  const Aabb box = triangle.bounds();
  places[0] = {box.lower, face, box.upper, splits};
  for (std::uint32_t place = 0; place <= splits;) {
    if (places[place].padding == 0) {
      ++place;
    } else {
      split_piece(grid, triangle, places + place);
    }
  }
}

/// The box that split_triangle writes to one place: goes from halves to halves, to those that own
/// the place, so that each place of a triangle can be filled on its own.
TREELET_HD inline Aabb find_piece(const MortonGrid& grid, const ExactTriangle& triangle,
                                  std::uint32_t splits, std::uint32_t place) {
  Aabb box = triangle.bounds();
  while (splits > 0) {
    const SplitBoxes half = split_box(grid, triangle, box);
    if (!is_nonempty(half.below)) break;
    const std::uint32_t below = share_splits(splits - 1, half);
    const bool is_below = place <= below;
    box = is_below ? half.below : half.above;
    splits = is_below ? below : splits - 1 - below;
    if (!is_below) place -= below + 1;
  }
  return box;
}

}  // namespace treelet
