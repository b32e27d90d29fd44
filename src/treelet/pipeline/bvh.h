#pragma once

#include <span>
#include <string>
#include <vector>

#include <treelet/core/stage.h>
#include <treelet/layout/bvh2.h>
#include <treelet/layout/statistics.h>
#include <treelet/query/intersect.h>
#include <treelet/tree/sah.h>

namespace treelet {

/// What a build did.
struct BuildReport {
  std::string recipe;  ///< with every argument written out
  std::vector<StageTime> stages;
  double seconds = 0.0;  ///< wall clock, arrays to traceable
  std::size_t faces = 0;
  std::size_t references = 0;
  std::size_t left_out_non_finite = 0;
  std::size_t left_out_degenerate = 0;
  TreeStatistics tree;
};

/// A built tree. Immutable, owns a copy of its triangles, and may be queried from many threads.
struct Bvh {
  Bvh2 layout;
  SahModel sah;
  BuildReport report;

  /// Closest hit; of equal t the smaller face.
  Hit intersect(const Ray& ray) const { return treelet::intersect(layout, ray); }
  bool is_occluded(const Ray& ray) const { return treelet::is_occluded(layout, ray); }

  /// One hit a ray, on all threads.
  std::vector<Hit> intersect(std::span<const Ray> rays) const;
};

}  // namespace treelet
