#pragma once

#include <array>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include <treelet/core/stage.h>
#include <treelet/layout/bvh2.h>
#include <treelet/layout/bvh8.h>
#include <treelet/layout/cwbvh.h>
#include <treelet/layout/statistics.h>
#include <treelet/query/all_hits.h>
#include <treelet/query/closest_point.h>
#include <treelet/query/hit_counts.h>
#include <treelet/query/intersect.h>
#include <treelet/query/lazy_moments.h>
#include <treelet/query/overlap.h>
#include <treelet/query/surface.h>
#include <treelet/tree/sah.h>

namespace treelet {

/// What updates did since the last build; zeros for a tree that cannot be updated.
struct UpdateReport {
  std::size_t refits = 0;
  double seconds = 0.0;    ///< wall clock of the last one
  double sah = 0.0;        ///< of the layout now, to be compared with BuildReport::tree.sah
  std::size_t hidden = 0;  ///< triangles in leaves that no ray can hit now (layout/refit_layout.h)
  std::size_t held_bytes = 0;  ///< memory of the tree and of what updates need
};

/// What a build did.
struct BuildReport {
  std::string recipe;  ///< with every argument written out
  std::vector<StageTime> stages{};
  double seconds = 0.0;  ///< wall clock, arrays to traceable
  std::size_t faces = 0;
  std::size_t references = 0;
  std::size_t left_out_non_finite = 0;
  std::size_t left_out_degenerate = 0;
  double sah = 0.0;       ///< of the binary tree with its best leaves: the same for every layout
  TreeStatistics tree{};  ///< of the layout
  UpdateReport update{};
};

/// How coordinates in doubles became the mesh's floats: float(coordinate - offset), the difference
/// in doubles. The caller does that, and with origins of rays; the tree remembers it
/// (docs/precision.md).
struct Placement {
  std::array<double, 3> offset{};
  double rounding = 0.0;  ///< how far rounding to float moved a vertex, at most
};

/// A built tree. Immutable, owns a copy of its triangles, and may be queried from many threads. For
/// meshes that move there is UpdatableBvh (pipeline/update.h).
struct Bvh {
  std::variant<Bvh2, Bvh8, Cwbvh> layout;
  SahModel sah;
  BuildReport report;
  Placement placement{};
  LazyMoments moments{};    ///< for winding_number
  Lazy<FaceTable> faces{};  ///< for triangles, normals and spawn

  /// Closest hit; of equal t the smaller face.
  Hit intersect(const Ray& ray) const;
  /// Whether anything is hit in [t_min, t_max].
  bool is_occluded(const Ray& ray) const;

  // One answer a ray, on all threads.
  std::vector<Hit> intersect(std::span<const Ray> rays) const;
  void intersect(const RayBatch& rays, const HitArrays& hits) const;
  void find_occluded(const RayBatch& rays, std::span<bool> occluded) const;
  /// What finding each ray's closest hit takes.
  void count_work(const RayBatch& rays, std::span<Work> work) const;

  // Every hit by the fill rule (query/hit_counts.h), sorted by (t, face): query/all_hits.h.
  std::vector<Hit> intersect_all(const Ray& ray, const AllHitsOptions& options = {}) const;
  AllHits intersect_all(const RayBatch& rays, const AllHitsOptions& options = {}) const;
  std::int64_t count_hits(const Ray& ray) const;
  void count_hits(const RayBatch& rays, std::span<std::int64_t> counts) const;

  /// The nearest point of the mesh, if it is at most `max_distance` away: query/closest_point.h.
  ClosestPoint closest_point(Vec3 point,
                             float max_distance = std::numeric_limits<float>::infinity()) const;
  void closest_point(const PointBatch& points, const ClosestPointArrays& answers) const;
  // Of a closed mesh, exact: query/contains.h. Each span holds one answer a point.
  void contains(const PointBatch& points, std::span<bool> answers) const;
  void signed_distance(const PointBatch& points, std::span<float> answers) const;
  /// Of any mesh: query/winding_number.h. The first call makes 52 bytes a child.
  void winding_number(const PointBatch& points, float accuracy, std::span<float> answers) const;
  // Faces that meet boxes and balls: query/overlap.h.
  Overlaps overlap_boxes(const BoxBatch& boxes) const;
  Overlaps overlap_spheres(const PointBatch& spheres) const;

  // Of faces, -1 for none: query/surface.h. The first call makes 4 bytes a face.
  void find_triangles(std::span<const std::int32_t> faces, std::span<Triangle> triangles) const;
  void find_normals(std::span<const std::int32_t> faces, const PerRay<Vec3>& facing,
                    std::span<Vec3> normals) const;
  void spawn(const SpawnBatch& rays, std::span<Vec3> origins) const;

  Aabb bounds() const;
  /// End-point overlap; see layout/epo.h.
  double epo(std::size_t max_triangles = 0) const;
  /// What is wrong with the tree; see layout/validate_layout.h.
  std::vector<std::string> validate() const;
  std::vector<std::string> validate(const Mesh& mesh) const;
};

}  // namespace treelet
