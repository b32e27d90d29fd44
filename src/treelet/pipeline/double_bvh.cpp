#include <treelet/pipeline/double_bvh.h>

#include <chrono>
#include <stdexcept>
#include <utility>
#include <variant>

#include <treelet/traverse/traverse_double.h>

namespace treelet {
namespace {

/// Boxes of parts of triangles are found in floats.
void check_recipe(const Recipe& recipe) {
  const std::string wrong = "a mesh in doubles takes recipes ";
  const std::string given = ", not '" + recipe.text() + "'";
  if (recipe.layout.word->name != "bvh8") {
    throw std::invalid_argument(wrong + "of the layout bvh8" + given);
  }
  if (recipe.splitter || recipe.builder.word->name == "sbvh") {
    throw std::invalid_argument(wrong +
                                "that split no triangles, without presplit, sbvh, trysplit and " +
                                "trysbvh, which the presets better and best use" + given);
  }
}

}  // namespace

DoubleHit DoubleBvh::intersect(const DoubleRay& ray) const {
  return DoubleRayTracer(layout).closest(ray);
}

bool DoubleBvh::is_occluded(const DoubleRay& ray) const { return DoubleRayTracer(layout).any(ray); }

std::vector<DoubleHit> DoubleBvh::intersect_all(const DoubleRay& ray) const {
  std::vector<DoubleHit> hits;
  DoubleRayTracer(layout).list(ray, hits);
  return hits;
}

std::int64_t DoubleBvh::count_hits(const DoubleRay& ray) const {
  return DoubleRayTracer(layout).count(ray);
}

std::vector<DoubleHit> DoubleBvh::intersect(std::span<const DoubleRay> rays) const {
  std::vector<DoubleHit> hits(rays.size());
  treelet::intersect(layout, rays, hits);
  return hits;
}

DoubleBvh build(const DoubleMesh& mesh, const Recipe& recipe, const BuildOptions& options) {
  check_recipe(recipe);
  check_indices(mesh);
  const auto start = std::chrono::steady_clock::now();
  const BoxFrame frame = fit_frame(mesh);
  Bvh boxes = build(make_box_mesh(mesh, frame).view(), recipe, options);
  DoubleBvh bvh{pack_double_bvh8(std::get<Bvh8>(std::move(boxes.layout)), mesh, frame),
                std::move(boxes.report)};
  bvh.report.tree.bytes = bvh.layout.bytes();
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  bvh.report.seconds = elapsed.count();
  return bvh;
}

DoubleBvh build(const DoubleMesh& mesh, std::string_view recipe, const BuildOptions& options) {
  return build(mesh, parse_recipe(recipe), options);
}

}  // namespace treelet
