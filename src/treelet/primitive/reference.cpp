#include <treelet/primitive/reference.h>

#include <array>
#include <vector>

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

Summary summarize(const Mesh& mesh, std::size_t begin, std::size_t end) {
  Summary summary;
  for (std::size_t i = begin; i < end; ++i) {
    const Triangle triangle = mesh.triangle(i);
    const TriangleKind kind = classify(triangle);
    ++summary[kind];
    if (kind == TriangleKind::regular) summary.bounds = merge(summary.bounds, bounds(triangle));
  }
  return summary;
}

void fill_range(const Mesh& mesh, std::size_t begin, std::size_t end, const PowerOfTwoScale& scale,
                Reference* out) {
  for (std::size_t i = begin; i < end; ++i) {
    const Triangle triangle = mesh.triangle(i);
    if (classify(triangle) != TriangleKind::regular) continue;
    *out++ = make_reference(triangle, std::uint32_t(i), scale);
  }
}

}  // namespace

References create_references(const Mesh& mesh) {
  const Stage stage{"create references"};
  const std::size_t count = mesh.faces.size();
  std::vector<Summary> summaries((count + kGrain - 1) / kGrain);
  parallel_for_ranges(count, kGrain, [&](std::size_t begin, std::size_t end) {
    summaries[begin / kGrain] = summarize(mesh, begin, end);
  });

  References references;
  std::vector<std::size_t> offsets;
  std::size_t total = 0;
  for (Summary& summary : summaries) {
    offsets.push_back(total);
    total += summary[TriangleKind::regular];
    references.left_out_non_finite += summary[TriangleKind::non_finite];
    references.left_out_degenerate += summary[TriangleKind::degenerate];
    references.bounds = merge(references.bounds, summary.bounds);
  }

  references.scale_exponent = extent_exponent(references.bounds);
  const PowerOfTwoScale scale(references.scale_exponent);
  if (total > 0) references.bounds = scale(references.bounds);
  references.items = Array<Reference>(total);
  parallel_for_ranges(count, kGrain, [&](std::size_t begin, std::size_t end) {
    fill_range(mesh, begin, end, scale, references.items.data() + offsets[begin / kGrain]);
  });
  return references;
}

}  // namespace treelet
