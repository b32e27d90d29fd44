#pragma once

#include <memory>
#include <span>
#include <string_view>

#include <treelet/core/arena.h>
#include <treelet/pipeline/build.h>

namespace treelet {

/// A tree over a mesh whose vertices move and whose faces stay. It keeps a copy of the faces and,
/// from the first rebuild on, the memory that a build takes.
///
/// An update may not run beside a query or another update of the same tree: that is for the caller
/// to see to. One that throws leaves the tree as it was.
class UpdatableBvh {
 public:
  /// Builds the tree; errors as build().
  UpdatableBvh(const Mesh& mesh, const Recipe& recipe, const BuildOptions& options = {});
  explicit UpdatableBvh(const Mesh& mesh, std::string_view recipe = "balanced",
                        const BuildOptions& options = {});

  /// For queries; the reference stays good for as long as the UpdatableBvh is not moved.
  const Bvh& bvh() const { return bvh_; }

  /// Moves the triangles and fits the boxes, but leaves the tree's shape: fast, and right however
  /// far vertices move, but slower to trace the less the mesh looks as it did when it was built.
  /// The report's update.sah against its tree.sah tells how much. Triangles that become bad are
  /// hidden, those that the build left out stay out (layout/refit_layout.h). Throws
  /// std::invalid_argument for another number of vertices.
  void refit(std::span<const Vec3> vertices);

  /// Runs the whole recipe again, in the memory that it has: from the second time on, a frame that
  /// needs no more than those before takes nothing from the system. The same tree as a new build.
  /// Throws as refit() and build().
  void rebuild(std::span<const Vec3> vertices);

  /// Throws std::invalid_argument unless the tree can be updated with so many vertices.
  void require_vertex_count(std::size_t count) const;

 private:
  Mesh moved_mesh(std::span<const Vec3> vertices) const;
  std::size_t held_bytes() const { return arena_->bytes() + faces_.bytes(); }

  Recipe recipe_;
  BuildOptions options_;
  std::size_t vertex_count_;
  Array<Face> faces_;
  std::shared_ptr<Arena> arena_ = std::make_shared<Arena>();
  Bvh bvh_;
};

}  // namespace treelet
