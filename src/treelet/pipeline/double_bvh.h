#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <treelet/layout/double_bvh8.h>
#include <treelet/pipeline/build.h>
#include <treelet/query/double_queries.h>

namespace treelet {

/// A built tree whose mesh, rays and answers are in doubles: nothing is rounded to floats but the
/// boxes, and those outwards. A hit is reported if and only if ray and triangle, as given in
/// doubles, meet; t, u and v are the exact ones, rounded once. Immutable, owns a copy of its
/// triangles, and may be queried from many threads. On the CPU, for rays: docs/precision.md.
struct DoubleBvh {
  DoubleBvh8 layout;
  BuildReport report;

  /// Closest hit; of equal t the smaller face.
  DoubleHit intersect(const DoubleRay& ray) const;
  /// Whether anything is hit in [t_min, t_max].
  bool is_occluded(const DoubleRay& ray) const;
  // Every hit by the fill rule (query/hit_counts.h), sorted by (t, face).
  std::vector<DoubleHit> intersect_all(const DoubleRay& ray) const;
  std::int64_t count_hits(const DoubleRay& ray) const;

  /// One answer a ray, on all threads; query/double_queries.h has the other queries of batches.
  std::vector<DoubleHit> intersect(std::span<const DoubleRay> rays) const;
};

/// As build() of a Mesh. Takes recipes that end in bvh8 and split no triangles;
/// std::invalid_argument for others.
DoubleBvh build(const DoubleMesh& mesh, const Recipe& recipe, const BuildOptions& options = {});
DoubleBvh build(const DoubleMesh& mesh, std::string_view recipe = "balanced",
                const BuildOptions& options = {});

}  // namespace treelet
