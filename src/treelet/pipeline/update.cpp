#include <treelet/pipeline/update.h>

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <string>

#include <treelet/layout/refit_layout.h>

namespace treelet {
namespace {

Array<Face> copy(std::span<const Face> faces) {
  Array<Face> copied(faces.size());
  std::copy(faces.begin(), faces.end(), copied.begin());
  return copied;
}

Bvh build_in(const std::shared_ptr<Arena>& arena, const Mesh& mesh, const Recipe& recipe,
             const BuildOptions& options) {
  const ArenaScope scope(arena);
  Bvh bvh = build(mesh, recipe, options);
  bvh.report.update.sah = bvh.report.tree.sah;
  return bvh;
}

}  // namespace

UpdatableBvh::UpdatableBvh(const Mesh& mesh, const Recipe& recipe, const BuildOptions& options)
    : recipe_(recipe),
      options_(options),
      vertex_count_(mesh.vertices.size()),
      faces_(copy(mesh.faces)),
      bvh_(build_in(arena_, mesh, recipe_, options_)) {
  arena_->release_free();  // who only refits needs no memory for builds
  bvh_.report.update.held_bytes = held_bytes();
}

UpdatableBvh::UpdatableBvh(const Mesh& mesh, std::string_view recipe, const BuildOptions& options)
    : UpdatableBvh(mesh, parse_recipe(recipe), options) {}

void UpdatableBvh::refit(std::span<const Vec3> vertices) {
  const Mesh mesh = moved_mesh(vertices);
  const ArenaScope scope(arena_);
  const auto start = std::chrono::steady_clock::now();
  const RefitResult result =
      std::visit([&](auto& layout) { return treelet::refit(layout, mesh, bvh_.sah); }, bvh_.layout);
  bvh_.moments.forget();
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  bvh_.report.update = {.refits = bvh_.report.update.refits + 1,
                        .seconds = elapsed.count(),
                        .sah = result.sah,
                        .hidden = result.hidden,
                        .held_bytes = held_bytes()};
}

void UpdatableBvh::rebuild(std::span<const Vec3> vertices) {
  // The old tree stays until the new one is there.
  bvh_ = build_in(arena_, moved_mesh(vertices), recipe_, options_);
  arena_->release_idle();  // what a larger frame has left
  bvh_.report.update.held_bytes = held_bytes();
}

Mesh UpdatableBvh::moved_mesh(std::span<const Vec3> vertices) const {
  require_vertex_count(vertices.size());
  return {vertices, faces_};
}

void UpdatableBvh::require_vertex_count(std::size_t count) const {
  if (count == vertex_count_) return;
  throw std::invalid_argument("the tree was built over " + std::to_string(vertex_count_) +
                              " vertices and cannot be updated with " + std::to_string(count) +
                              ": an update moves vertices, it neither adds nor removes any");
}

}  // namespace treelet
