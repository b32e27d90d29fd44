#include <treelet/primitive/reference.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>
#include <vector>

#include <treelet/core/box_lanes.h>
#include <treelet/core/parallel.h>
#include <treelet/core/stage.h>
#include <treelet/primitive/reference_steps.h>

namespace treelet {
namespace {

constexpr std::size_t kGrain = 1 << 14;

/// What one range of faces contributes; kinds are counted by TriangleKind.
struct Summary {
  Aabb bounds = Aabb::empty();
  std::array<std::size_t, 3> count{};

  std::size_t& operator[](TriangleKind kind) { return count[std::size_t(kind)]; }
};

/// The scale of the box of all vertices: nearly always that of the regular triangles, whose box is
/// known only when they have been gone through.
int guess_scale_exponent(const Mesh& mesh) {
  const Aabb box = parallel_reduce(
      mesh.vertices.size(), kGrain, Aabb::empty(),
      [&](std::size_t begin, std::size_t end) {
        Aabb range = Aabb::empty();
        for (const Vec3 vertex : mesh.vertices.subspan(begin, end - begin)) {
          if (is_finite(vertex)) range = merge(range, vertex);
        }
        return range;
      },
      [](const Aabb& a, const Aabb& b) { return merge(a, b); });
  return extent_exponent(box);
}

BoxLanes bounds_in_lanes(const Triangle& triangle) {
  const auto a = BoxLanes::load(triangle.p0), b = BoxLanes::load(triangle.p1),
             c = BoxLanes::load(triangle.p2);
  return {BoxLanes::min(BoxLanes::min(a, b), c), BoxLanes::max(BoxLanes::max(a, b), c)};
}

/// make_reference (primitive/reference_steps.h), bit for bit.
class ReferenceWriter {
 public:
  explicit ReferenceWriter(const PowerOfTwoScale& scale)
      : first_(BoxLanes::Floats{} + scale.first()), second_(BoxLanes::Floats{} + scale.second()) {}

  void write(const BoxLanes& box, std::uint32_t face, Reference* out) const {
    const BoxLanes::Floats halves[2] = {BoxLanes::with_number(scaled(box.lower), face),
                                        BoxLanes::with_number(scaled(box.upper), 0)};
    static_assert(sizeof(halves) == sizeof(Reference));
    std::memcpy(static_cast<void*>(out), halves, sizeof(halves));
  }

 private:
  BoxLanes::Floats scaled(BoxLanes::Floats x) const {
    constexpr BoxLanes::Floats kZero{}, kLimit = kZero + kBuildSpaceLimit;
    return BoxLanes::max(-kLimit, BoxLanes::min(x * first_ * second_ + kZero, kLimit));
  }

  const BoxLanes::Floats first_, second_;
};

/// Writes the references of a range of faces, one behind the other.
Summary write_range(const Mesh& mesh, std::size_t begin, std::size_t end,
                    const PowerOfTwoScale& scale, Reference* out) {
  const ReferenceWriter writer(scale);
  BoxLanes range = BoxLanes::empty();
  Summary summary;
  for (std::size_t i = begin; i < end; ++i) {
    const Triangle triangle = mesh.triangle(i);
    const TriangleKind kind = classify(triangle);
    ++summary[kind];
    if (kind != TriangleKind::regular) continue;
    const BoxLanes box = bounds_in_lanes(triangle);
    range.add(box);
    writer.write(box, std::uint32_t(i), out++);
  }
  summary.bounds = range.box();
  return summary;
}

/// References by ranges of faces, each in the place that its faces would fill if all were regular.
struct Ranges {
  Array<Reference> items;
  std::vector<Summary> summaries;

  Ranges(const Mesh& mesh, int scale_exponent)
      : items(mesh.faces.size()), summaries((items.size() + kGrain - 1) / kGrain) {
    const PowerOfTwoScale scale(scale_exponent);
    parallel_for_ranges(items.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      summaries[begin / kGrain] = write_range(mesh, begin, end, scale, &items[begin]);
    });
  }

  Aabb bounds() const {
    Aabb all = Aabb::empty();
    for (const Summary& summary : summaries) all = merge(all, summary.bounds);
    return all;
  }

  std::size_t count(TriangleKind kind) const {
    std::size_t all = 0;
    for (Summary summary : summaries) all += summary[kind];
    return all;
  }

  /// Without the gaps that triangles left out have made.
  Array<Reference> close_gaps() {
    const std::size_t total = count(TriangleKind::regular);
    if (total == items.size()) return std::move(items);
    Array<Reference> closed(total);
    Reference* out = closed.begin();
    for (std::size_t range = 0; range < summaries.size(); ++range) {
      out = std::copy_n(&items[range * kGrain], summaries[range][TriangleKind::regular], out);
    }
    return closed;
  }
};

}  // namespace

References create_references(const Mesh& mesh) {
  const Stage stage{"create references"};
  const int guess = guess_scale_exponent(mesh);
  Ranges ranges(mesh, guess);
  References references;
  references.bounds = ranges.bounds();
  references.scale_exponent = extent_exponent(references.bounds);
  if (references.scale_exponent != guess) ranges = Ranges(mesh, references.scale_exponent);
  references.left_out_non_finite = ranges.count(TriangleKind::non_finite);
  references.left_out_degenerate = ranges.count(TriangleKind::degenerate);
  references.items = ranges.close_gaps();
  const PowerOfTwoScale scale(references.scale_exponent);
  if (references.size() > 0) references.bounds = scale(references.bounds);
  return references;
}

}  // namespace treelet
