#include <treelet/build/split_planes.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include <treelet/core/parallel.h>
#include <treelet/primitive/split_steps.h>

namespace treelet {
namespace {

using Floats = BoxLanes::Floats;
using Ints = BoxLanes::Ints;

constexpr std::size_t kGrain = 1 << 13;
constexpr int kChoppedBins = 16;  ///< of an axis at least, to cut boxes instead of triangles

/// What falls into one bin. A piece across several begins in one and ends in another.
struct PlaneBin {
  BoxLanes box;
  std::uint32_t begin, end;

  static PlaneBin empty() { return {BoxLanes::empty(), 0, 0}; }

  void add(const PlaneBin& other) {
    box.add(other.box);
    begin += other.begin;
    end += other.end;
  }
};

/// A power of two that floats may not hold, as a product of two that they do.
struct RoughScale {
  float first, second;

  explicit RoughScale(double scale)
      : first(float(std::ldexp(1.0, std::ilogb(scale) / 2))), second(float(scale / first)) {}
};

/// A triangle as floats: near enough to choose a plane by. What is built takes halve().
struct RoughTriangle {
  std::array<Floats, 3> vertex;

  RoughTriangle(const Mesh& mesh, std::uint32_t face, const RoughScale& scale) {
    const Face& corners = mesh.faces[face];
    for (std::size_t i = 0; i < 3; ++i) {
      vertex[i] = BoxLanes::load(mesh.vertices[corners[i]]) * scale.first * scale.second;
    }
  }
};

Floats spread(float x) { return Floats{} + x; }

/// Where planes across one axis cut a triangle. Its vertices are sorted along the axis: the edge
/// from the lowest to the highest meets all planes between, the other two share them.
template <int kAxis>
class Slices {
 public:
  explicit Slices(const RoughTriangle& triangle)
      : low(triangle.vertex[0]), middle(triangle.vertex[1]), high(triangle.vertex[2]) {
    sort(low, middle);
    sort(middle, high);
    sort(low, middle);
    along_ = (high - low) / (high[kAxis] - low[kAxis]);
    below_ = (middle - low) / (middle[kAxis] - low[kAxis]);
    above_ = (high - middle) / (high[kAxis] - middle[kAxis]);
  }

  /// Not a number where an edge lies in the plane; see add_parts.
  BoxLanes at(float plane) const {
    const Floats a = low + along_ * (plane - low[kAxis]);
    const Floats b = low + below_ * (plane - low[kAxis]);
    const Floats c = middle + above_ * (plane - middle[kAxis]);
    const Floats other = spread(plane) < spread(middle[kAxis]) ? b : c;
    return {BoxLanes::min(a, other), BoxLanes::max(a, other)};
  }

  Floats low, middle, high;

 private:
  /// Without branches, which nobody could predict.
  static void sort(Floats& a, Floats& b) {
    const Ints is_wrong = spread(b[kAxis]) < spread(a[kAxis]);
    const Floats lower = is_wrong ? b : a;
    b = is_wrong ? a : b;
    a = lower;
  }

  Floats along_, below_, above_;  // steps of the edges, one unit of the axis long
};

bool is_nonempty(const BoxLanes& box) {
  const Ints is = box.lower <= box.upper;
  return (is[0] & is[1] & is[2]) != 0;
}

/// Only so many bins of each axis as the grid has are in use.
class PlaneBinSet {
 public:
  using Axis = std::array<PlaneBin, kMaxPlaneBins>;

  void clear(int bins) {
    for (Axis& axis : axes_) std::fill_n(axis.begin(), bins, PlaneBin::empty());
  }

  void fill(std::span<const BinaryNode> pieces, const PlaneGrid& grid, const SplitSource& source) {
    const RoughScale scale(source.scale);
    const int most_chopped = grid.bins() >= kChoppedBins ? 1 : 0;
    for (const BinaryNode& piece : pieces) {
      const BoxLanes box = BoxLanes::load_box(piece);
      const Ints first = grid.of(box.lower), last = grid.of(box.upper);
      const Ints across = last - first;  // bins
      if (std::max({across[0], across[1], across[2]}) <= most_chopped) {
        add_chopped(box, first, last, grid);
      } else {
        const RoughTriangle triangle(source.mesh, piece.index, scale);
        add<0>(first[0], last[0], box, triangle, grid);
        add<1>(first[1], last[1], box, triangle, grid);
        add<2>(first[2], last[2], box, triangle, grid);
      }
    }
  }

  void add(const PlaneBinSet& other, int bins) {
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t k = 0; k < std::size_t(bins); ++k) axes_[i][k].add(other.axes_[i][k]);
    }
  }

  const Axis& axis(int i) const { return axes_[std::size_t(i)]; }

 private:
  void add_whole(int axis, int bin, const BoxLanes& box) {
    axes_[std::size_t(axis)][std::size_t(bin)].add({box, 1, 1});
  }

  /// Cuts the box instead of the triangle, which need not be read: a box across no more than two
  /// bins of an axis is small beside the node.
  void add_chopped(const BoxLanes& box, Ints first, Ints last, const PlaneGrid& grid) {
    const Floats upper = BoxLanes::min(box.upper, grid.planes(first + 1));
    const Floats lower = BoxLanes::max(box.lower, grid.planes(last));
    for (int axis = 0; axis < 3; ++axis) {
      BoxLanes below = box, above = box;
      below.upper[axis] = upper[axis];
      above.lower[axis] = lower[axis];
      Axis& bins = axes_[std::size_t(axis)];
      PlaneBin &in = bins[std::size_t(first[axis])], &out = bins[std::size_t(last[axis])];
      in.box.add(below);
      ++in.begin;
      out.box.add(above);
      ++out.end;
    }
  }

  template <int kAxis>
  void add(int first, int last, const BoxLanes& box, const RoughTriangle& triangle,
           const PlaneGrid& grid) {
    if (first == last) return add_whole(kAxis, first, box);
    Axis& bins = axes_[kAxis];
    ++bins[std::size_t(first)].begin;
    ++bins[std::size_t(last)].end;
    add_parts<kAxis>(bins, first, last, box, Slices<kAxis>(triangle), grid);
  }

  /// Puts into each bin the box of what lies there of a piece across several [Stich2009 s4.3]: of
  /// the slices on both sides and of the vertices between. A slice that is not a number adds
  /// nothing as the later one, and as the earlier one leaves all of the piece's box.
  template <int kAxis>
  static void add_parts(Axis& bins, int first, int last, const BoxLanes& box,
                        const Slices<kAxis>& slices, const PlaneGrid& grid) {
    const float lower = box.lower[kAxis], upper = box.upper[kAxis];
    const float middle = slices.middle[kAxis];
    const int middle_bin = lower <= middle && middle <= upper ? grid.of(slices.middle)[kAxis] : -1;
    BoxLanes part = slices.low[kAxis] < lower ? slices.at(lower) : BoxLanes{slices.low, slices.low};
    for (int bin = first; bin <= last; ++bin) {
      const BoxLanes slice = bin < last                   ? slices.at(grid.plane(kAxis, bin + 1))
                             : slices.high[kAxis] > upper ? slices.at(upper)
                                                          : BoxLanes{slices.high, slices.high};
      part.add(slice);
      if (bin == middle_bin) part.add_point(slices.middle);
      const BoxLanes inside{BoxLanes::max(box.lower, part.lower),
                            BoxLanes::min(box.upper, part.upper)};
      if (is_nonempty(inside)) bins[std::size_t(bin)].box.add(inside);
      part = slice;
    }
  }

  std::array<Axis, 3> axes_;
};

/// Fills bins a chunk a task, and adds them up in order.
void fill_in_parallel(std::span<const BinaryNode> pieces, const PlaneGrid& grid,
                      const SplitSource& source, PlaneBinSet& bins) {
  std::vector<PlaneBinSet> chunks((pieces.size() + kGrain - 1) / kGrain);
  parallel_for_ranges(pieces.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    PlaneBinSet& chunk = chunks[begin / kGrain];
    chunk.clear(grid.bins());
    chunk.fill(pieces.subspan(begin, end - begin), grid, source);
  });
  for (const PlaneBinSet& chunk : chunks) bins.add(chunk, grid.bins());
}

/// Looks at each plane of an axis with pieces on both sides.
class PlaneSweep {
 public:
  PlaneSweep(const PlaneGrid& grid, int axis) : grid_(grid), axis_(axis) {}

  void run(const PlaneBinSet::Axis& bins, SpatialSplit& best) const {
    const std::size_t count = std::size_t(grid_.bins());
    std::array<PlaneBin, kMaxPlaneBins> above;
    PlaneBin sum = PlaneBin::empty();
    for (std::size_t k = count; k-- > 1;) {
      sum.add(bins[k]);
      above[k] = sum;
    }
    PlaneBin below = PlaneBin::empty();
    for (std::size_t k = 1; k < count; ++k) {
      below.add(bins[k - 1]);
      if (below.begin > 0 && above[k].end > 0) consider(int(k), below, above[k], best);
    }
  }

 private:
  void consider(int bin, const PlaneBin& below, const PlaneBin& above, SpatialSplit& best) const {
    const float cost =
        below.box.half_area() * float(below.begin) + above.box.half_area() * float(above.end);
    const auto imbalance = std::max(below.begin, above.end);
    if (cost > best.cost) return;
    if (cost == best.cost && imbalance >= std::max(best.left_count, best.right_count)) return;
    best = {cost, axis_, grid_.plane(axis_, bin), below.box, above.box, below.begin, above.end};
  }

  const PlaneGrid& grid_;
  const int axis_;
};

}  // namespace

PlaneGrid::PlaneGrid(const BoxLanes& box, int bins) : lower_(box.lower), bins_(bins) {
  lower_[3] = 0.0f;
  for (int axis = 0; axis < 3; ++axis) {
    const float from = box.lower[axis], to = box.upper[axis];
    const float width = (to - from) / float(bins), scale = 1.0f / width;
    // A width that is lost beside the coordinates would put planes outside.
    const bool is_wide = width > 0.0f && from + width > from && to - width < to;
    if (!is_wide || !(scale < std::numeric_limits<float>::max())) continue;
    width_[axis] = width;
    scale_[axis] = scale;
  }
}

SpatialSplit find_spatial_split(std::span<const BinaryNode> pieces, const BoxLanes& box,
                                const SplitSource& source) {
  const PlaneGrid grid(box, plane_bins(pieces.size()));
  PlaneBinSet bins;
  bins.clear(grid.bins());
  if (pieces.size() <= kGrain) {
    bins.fill(pieces, grid, source);
  } else {
    fill_in_parallel(pieces, grid, source, bins);
  }
  SpatialSplit best;
  for (int axis = 0; axis < 3; ++axis) {
    if (grid.can_part(axis)) PlaneSweep(grid, axis).run(bins.axis(axis), best);
  }
  return best;
}

PieceHalves halve(const BinaryNode& piece, int axis, float plane, const SplitSource& source) {
  const Aabb box = piece.box();
  if (plane <= box.lower[axis]) return {Aabb::empty(), box};
  if (plane >= box.upper[axis]) return {box, Aabb::empty()};
  const ExactTriangle triangle(source.mesh.triangle(piece.index), source.scale);
  const SplitBoxes whole = clip_at_plane(triangle, axis, plane);
  return {overlap(whole.below, box), overlap(whole.above, box)};
}

}  // namespace treelet
