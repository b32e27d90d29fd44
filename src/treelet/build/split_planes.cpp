#include <treelet/build/split_planes.h>

#include <algorithm>
#include <array>
#include <utility>

#include <treelet/core/parallel.h>
#include <treelet/primitive/split_steps.h>

namespace treelet {
namespace {

constexpr std::size_t kGrain = 1 << 13;

/// What falls into one bin. A reference across several begins in one and ends in another.
struct Bin {
  Aabb box;
  std::uint32_t begin, end;

  static Bin empty() { return {Aabb::empty(), 0, 0}; }

  void add(const Aabb& part) { box = merge(box, part); }
};

using AxisBins = std::array<Bin, Bins::kMost>;

/// The bins of all axes, the same number of each.
struct BinSet {
  int count = 0;
  std::array<AxisBins, 3> axis;

  explicit BinSet(int bins) : count(bins) {}

  static BinSet merged(const BinSet& a, const BinSet& b) {
    if (a.count == 0) return b;
    BinSet sum = a;
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t k = 0; k < std::size_t(a.count); ++k) {
        Bin& bin = sum.axis[i][k];
        bin.add(b.axis[i][k].box);
        bin.begin += b.axis[i][k].begin;
        bin.end += b.axis[i][k].end;
      }
    }
    return sum;
  }
};

/// add(bins, reference) for each, on all threads where there are many.
template <class Add>
BinSet fill_bins(std::span<const Reference> references, int count, Add&& add) {
  const auto fill = [&](std::size_t begin, std::size_t end) {
    BinSet bins(count);
    for (auto& axis : bins.axis) std::fill_n(axis.begin(), bins.count, Bin::empty());
    for (const Reference& reference : references.subspan(begin, end - begin)) add(bins, reference);
    return bins;
  };
  if (references.size() <= kGrain) return fill(0, references.size());
  return parallel_reduce(references.size(), kGrain, BinSet(0), fill, BinSet::merged);
}

/// The best of the planes between bins, of each axis.
struct PlaneChoice {
  float cost = kNoSplit;
  int axis = 0, bin = 0;
  std::uint32_t imbalance = 0;  // decides between equal costs
  Aabb left = Aabb::empty(), right = Aabb::empty();
  std::uint32_t left_count = 0, right_count = 0;

  bool better_than(const PlaneChoice& other) const {
    return cost != other.cost ? cost < other.cost : imbalance < other.imbalance;
  }
};

float weigh(const Aabb& box, std::uint32_t count) {
  return count == 0 ? 0.0f : half_area(box) * float(count);
}

void consider_axis(const AxisBins& bins, int count, int axis, PlaneChoice& best) {
  std::array<Bin, Bins::kMost> right;  // from a bin to the last
  Bin sum = Bin::empty();
  for (int k = count; k-- > 1;) {
    sum.add(bins[std::size_t(k)].box);
    sum.end += bins[std::size_t(k)].end;
    right[std::size_t(k)] = sum;
  }
  Bin left = Bin::empty();
  for (int k = 1; k < count; ++k) {
    left.add(bins[std::size_t(k) - 1].box);
    left.begin += bins[std::size_t(k) - 1].begin;
    const Bin& rest = right[std::size_t(k)];
    if (left.begin == 0 || rest.end == 0) continue;
    const PlaneChoice choice{weigh(left.box, left.begin) + weigh(rest.box, rest.end),
                             axis,
                             k,
                             std::max(left.begin, rest.end),
                             left.box,
                             rest.box,
                             left.begin,
                             rest.end};
    if (choice.better_than(best)) best = choice;
  }
}

PlaneChoice choose_plane(const BinSet& set, const std::array<Bins, 3>& bins) {
  PlaneChoice best;
  for (int axis = 0; axis < 3; ++axis) {
    const std::size_t i = std::size_t(axis);
    if (bins[i].can_part()) consider_axis(set.axis[i], set.count, axis, best);
  }
  return best;
}

std::array<Bins, 3> bins_over(const Aabb& box, int count) {
  return {Bins(box.lower.x, box.upper.x, count), Bins(box.lower.y, box.upper.y, count),
          Bins(box.lower.z, box.upper.z, count)};
}

Aabb bound_centroids(std::span<const Reference> references) {
  const auto bound = [&](std::size_t begin, std::size_t end) {
    Aabb box = Aabb::empty();
    for (const Reference& reference : references.subspan(begin, end - begin)) {
      box = merge(box, doubled_centroid(reference.box()));
    }
    return box;
  };
  if (references.size() <= kGrain) return bound(0, references.size());
  return parallel_reduce(references.size(), kGrain, Aabb::empty(), bound,
                         [](const Aabb& a, const Aabb& b) { return merge(a, b); });
}

/// A triangle as floats: near enough to choose a plane by. What is built takes halve().
struct RoughTriangle {
  std::array<Vec3, 3> vertex;

  RoughTriangle(const Reference& reference, const SplitSource& source) {
    const Triangle t = source.mesh.triangle(reference.face);
    const auto scaled = [&](float x) { return float(x * source.scale); };
    const auto at = [&](Vec3 p) { return Vec3{scaled(p.x), scaled(p.y), scaled(p.z)}; };
    vertex = {at(t.p0), at(t.p1), at(t.p2)};
  }
};

/// Puts into each bin the box of what lies there of a reference across several [Stich2009 s4.3]:
/// each vertex into its bin, each point where an edge meets a plane into the bins on both sides.
void add_parts(AxisBins& bins, const Bins& grid, int axis, const Reference& reference,
               const RoughTriangle& triangle) {
  const int first = grid.of(reference.lower[axis]), last = grid.of(reference.upper[axis]);
  std::array<Aabb, Bins::kMost> parts;
  for (int k = first; k <= last; ++k) parts[std::size_t(k)] = Aabb::empty();
  const auto add = [&](int bin, Vec3 point) {
    if (first <= bin && bin <= last) {
      parts[std::size_t(bin)] = merge(parts[std::size_t(bin)], point);
    }
  };
  for (std::size_t i = 0; i < 3; ++i) {
    Vec3 p = triangle.vertex[i], q = triangle.vertex[(i + 1) % 3];
    add(grid.of(p[axis]), p);
    if (q[axis] < p[axis]) std::swap(p, q);
    const int from = std::max(grid.of(p[axis]), first), to = std::min(grid.of(q[axis]), last);
    const float length = q[axis] - p[axis];
    for (int k = from; k < to; ++k) {
      const Vec3 crossing = p + (q - p) * ((grid.plane(k + 1) - p[axis]) / length);
      add(k, crossing);
      add(k + 1, crossing);
    }
  }
  ++bins[std::size_t(first)].begin;
  ++bins[std::size_t(last)].end;
  for (int k = first; k <= last; ++k) {
    const Aabb part = overlap(parts[std::size_t(k)], reference.box());
    if (is_nonempty(part)) bins[std::size_t(k)].add(part);
  }
}

void add_to_axes(BinSet& set, const std::array<Bins, 3>& bins, const Reference& reference,
                 const SplitSource& source) {
  const RoughTriangle triangle(reference, source);
  for (int axis = 0; axis < 3; ++axis) {
    const std::size_t i = std::size_t(axis);
    if (!bins[i].can_part()) continue;
    const int first = bins[i].of(reference.lower[axis]);
    if (first != bins[i].of(reference.upper[axis])) {
      add_parts(set.axis[i], bins[i], axis, reference, triangle);
      continue;
    }
    Bin& bin = set.axis[i][std::size_t(first)];
    bin.add(reference.box());
    ++bin.begin;
    ++bin.end;
  }
}

}  // namespace

Bins::Bins(float from, float to, int intervals) : lower(from), count(intervals) {
  const float width = (to - from) / float(count);
  // A width that is lost beside the coordinates would put planes outside.
  const bool is_wide = width > 0.0f && from + width > from && to - width < to;
  scale = is_wide ? 1.0f / width : 0.0f;
  if (!(scale < std::numeric_limits<float>::max())) scale = 0.0f;
}

ObjectSplit find_object_split(std::span<const Reference> references) {
  const int count = bin_count(references.size());
  const std::array<Bins, 3> bins = bins_over(bound_centroids(references), count);
  const BinSet set = fill_bins(references, count, [&](BinSet& into, const Reference& reference) {
    const Vec3 centroid = doubled_centroid(reference.box());
    for (int axis = 0; axis < 3; ++axis) {
      const std::size_t i = std::size_t(axis);
      Bin& bin = into.axis[i][std::size_t(bins[i].of(centroid[axis]))];
      bin.add(reference.box());
      ++bin.begin;
      ++bin.end;
    }
  });
  const PlaneChoice best = choose_plane(set, bins);
  return {best.cost, best.axis, best.bin, bins[std::size_t(best.axis)], best.left, best.right};
}

SpatialSplit find_spatial_split(std::span<const Reference> references, const Aabb& box,
                                const SplitSource& source) {
  const int count = bin_count(references.size());
  const std::array<Bins, 3> bins = bins_over(box, count);
  const BinSet set = fill_bins(references, count, [&](BinSet& into, const Reference& reference) {
    add_to_axes(into, bins, reference, source);
  });
  const PlaneChoice best = choose_plane(set, bins);
  if (!(best.cost < kNoSplit)) return {};
  return {best.cost,       best.axis,  bins[std::size_t(best.axis)].plane(best.bin),
          best.left,       best.right, best.left_count,
          best.right_count};
}

ReferenceHalves halve(const Reference& reference, int axis, float plane,
                      const SplitSource& source) {
  const Aabb box = reference.box();
  if (plane <= box.lower[axis]) return {Aabb::empty(), box};
  if (plane >= box.upper[axis]) return {box, Aabb::empty()};
  const ExactTriangle triangle(source.mesh.triangle(reference.face), source.scale);
  const SplitBoxes whole = clip_at_plane(triangle, axis, plane);
  return {overlap(whole.below, box), overlap(whole.above, box)};
}

}  // namespace treelet
