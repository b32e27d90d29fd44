#include <treelet/pipeline/split_trial.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <treelet/layout/pack_cwbvh.h>
#include <treelet/layout/wide_collapse.h>
#include <treelet/query/surface_rays.h>

namespace treelet {
namespace {

constexpr std::string_view kTrySplit = "trysplit", kTrySbvh = "trysbvh";

/// Enough for work to be off by a percent or so; fewer where the mesh is built in no time.
std::size_t ray_count(const Mesh& mesh) {
  return std::clamp<std::size_t>(mesh.faces.size() / 8, 1024, 8192);
}

/// Of a node and of a triangle, as the layout's collapse has it.
struct VisitCosts {
  double node, triangle;
};
VisitCosts visit_costs(const Bvh2&) {
  return {SahModel{}.traversal_cost, SahModel{}.intersection_cost};
}
VisitCosts visit_costs(const Bvh8&) {
  constexpr double kTrianglesABlock = 3.0;  // of four places
  return {WideCostModel{}.node_cost, WideCostModel{}.block_cost / kTrianglesABlock};
}
VisitCosts visit_costs(const Cwbvh&) {
  return {CwbvhCostModel{}.node_cost, CwbvhCostModel{}.triangle_cost};
}

/// Counts in whole numbers: their sums are the same in any order.
double count_work(const Bvh& bvh, std::span<const Ray> rays) {
  std::vector<Work> work(rays.size());
  bvh.count_work(rays, work);
  double nodes = 0.0, triangles = 0.0;
  for (const Work& of_ray : work) {
    nodes += of_ray.nodes;
    triangles += of_ray.triangles;
  }
  const VisitCosts costs =
      std::visit([](const auto& layout) { return visit_costs(layout); }, bvh.layout);
  return costs.node * nodes + costs.triangle * triangles;
}

const RecipeWord& find_word(std::string_view name) {
  return *std::ranges::find(recipe_words(), name, &RecipeWord::name);
}

Recipe without_splits(Recipe recipe) {
  recipe.splitter.reset();
  return recipe;
}

/// Splits come before the builder, or the builder that splits in its place.
Recipe with_splits(Recipe recipe) {
  const RecipeStage trial = *recipe.splitter;
  if (trial.word->name == kTrySbvh) {
    recipe.builder = RecipeStage{&find_word("sbvh"), {trial.value("budget")}};
    return without_splits(std::move(recipe));
  }
  recipe.splitter = RecipeStage{&find_word("presplit"), {trial.value("budget")}};
  return recipe;
}

/// Work of a ray in the split tree over that in the whole one; 1 where no ray costs anything.
double compare_work(const Mesh& mesh, const Bvh& whole, const Bvh& split) {
  const std::vector<Ray> rays = make_surface_rays(mesh, ray_count(mesh));
  const double before = count_work(whole, rays);
  return before > 0.0 ? count_work(split, rays) / before : 1.0;
}

std::string describe(double work, bool is_split) {
  char text[64];
  std::snprintf(text, sizeof(text), "count work: %.3f with splits, %s", work,
                is_split ? "kept" : "refused");
  return text;
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

bool tries_splitting(const Recipe& recipe) {
  if (!recipe.splitter) return false;
  const std::string_view name = recipe.splitter->word->name;
  return name == kTrySplit || name == kTrySbvh;
}

Bvh build_by_trial(const Mesh& mesh, const Recipe& recipe, const BuildOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  Bvh whole = build(mesh, without_splits(recipe), options);
  Bvh split = build(mesh, with_splits(recipe), options);
  const auto count_start = std::chrono::steady_clock::now();
  const double work = compare_work(mesh, whole, split);
  const bool is_split = work < 1.0 - recipe.splitter->value("margin") / 100.0;
  const double counting = seconds_since(count_start);
  BuildReport& report = (is_split ? split : whole).report;
  const StageTime other = is_split ? StageTime{"try without splits", whole.report.seconds}
                                   : StageTime{"try with splits", split.report.seconds};
  report.stages.insert(is_split ? report.stages.begin() : report.stages.end(), other);
  report.stages.push_back({describe(work, is_split), counting});
  report.recipe = recipe.text();
  report.seconds = seconds_since(start);
  return std::move(is_split ? split : whole);
}

}  // namespace treelet
