#include <treelet/pipeline/build.h>

#include <array>
#include <chrono>
#include <stdexcept>
#include <utility>

#include <treelet/build/hploc.h>
#include <treelet/build/lbvh.h>
#include <treelet/build/sbvh.h>
#include <treelet/build/sweep.h>
#include <treelet/layout/leaf_collapse.h>
#include <treelet/layout/pack_bvh2.h>
#include <treelet/layout/pack_bvh8.h>
#include <treelet/layout/pack_cwbvh.h>
#include <treelet/optimize/reinsertion.h>
#include <treelet/optimize/treelet.h>
#include <treelet/primitive/split.h>
#include <treelet/tree/validate.h>

namespace treelet {
namespace {

// Some builders split references on the way.
using Builder = BinaryTree (*)(References&, const Mesh&, const SahModel&, const RecipeStage&);
using Optimizer = void (*)(BinaryTree&, const SahModel&, const RecipeStage&);

BinaryTree run_lbvh(References& references, const Mesh&, const SahModel&, const RecipeStage&) {
  return build_lbvh(references);
}

BinaryTree run_hploc(References& references, const Mesh&, const SahModel&,
                     const RecipeStage& stage) {
  return build_hploc(references, {.radius = int(stage.value("radius"))});
}

BinaryTree run_sweep(References& references, const Mesh&, const SahModel&, const RecipeStage&) {
  return build_sweep(references);
}

BinaryTree run_sbvh(References& references, const Mesh& mesh, const SahModel& sah,
                    const RecipeStage& stage) {
  return build_sbvh(references, mesh, {.sah = sah, .budget = float(stage.value("budget"))});
}

void run_treelet(BinaryTree& tree, const SahModel& sah, const RecipeStage& stage) {
  const TreeletConfig config{.size = int(stage.value("size")),
                             .rounds = int(stage.value("rounds")),
                             .gamma = std::uint32_t(stage.value("gamma"))};
  restructure_treelets(tree, sah, config);
}

void run_reinsert(BinaryTree& tree, const SahModel&, const RecipeStage& stage) {
  reinsert_nodes(tree,
                 {.percent = float(stage.value("percent")), .rounds = int(stage.value("rounds"))});
}

/// A tree and what it was built over. A packer takes both, and lets go of them when it can.
struct Built {
  References references;
  BinaryTree tree;
};

using Layout = decltype(Bvh::layout);
struct Packed {
  Layout layout;
  double sah;  ///< of the binary tree
};
using Packer = Packed (*)(Built, const Mesh&, const SahModel&, const RecipeStage&);

Packed run_bvh2(Built built, const Mesh& mesh, const SahModel& sah, const RecipeStage&) {
  return {pack_bvh2(built.tree, built.references, mesh, sah),
          collapsed_sah_cost(built.tree, built.references, sah)};
}

Packed run_bvh8(Built built, const Mesh& mesh, const SahModel& sah, const RecipeStage& stage) {
  const WideCostModel model{.leaf_limit = std::uint32_t(stage.value("leaf"))};
  check_bvh8_model(model);
  WideCollapse collapse = collapse_wide(built.tree, built.references, model, sah);
  const Bvh8Plan plan = plan_bvh8(built.tree, built.references, collapse);
  const double cost = collapse.sah;
  // In this order: an arena would lend the layout the larger blocks of what is let go.
  Bvh8 bvh = allocate_bvh8(plan);
  built = {};
  collapse = {};
  write_bvh8(plan, mesh, bvh);
  return {std::move(bvh), cost};
}

Packed run_cwbvh(Built built, const Mesh& mesh, const SahModel& sah, const RecipeStage& stage) {
  const CwbvhCostModel model{.leaf_limit = std::uint32_t(stage.value("leaf"))};
  return {pack_cwbvh(built.tree, built.references, mesh, model),
          collapsed_sah_cost(built.tree, built.references, sah)};
}

template <class Function>
struct Entry {
  std::string_view word;
  Function run;
};

constexpr std::array<Entry<Builder>, 4> kBuilders{
    {{"lbvh", run_lbvh}, {"hploc", run_hploc}, {"sweep", run_sweep}, {"sbvh", run_sbvh}}};
constexpr std::array<Entry<Optimizer>, 2> kOptimizers{
    {{"treelet", run_treelet}, {"reinsert", run_reinsert}}};
constexpr std::array<Entry<Packer>, 3> kPackers{
    {{"bvh2", run_bvh2}, {"bvh8", run_bvh8}, {"cwbvh", run_cwbvh}}};

template <class Table>
auto find_function(const Table& table, std::string_view word) {
  for (const auto& entry : table) {
    if (entry.word == word) return entry.run;
  }
  throw std::logic_error("no function for the recipe word '" + std::string(word) + "'");
}

void require_sound(std::string_view stage, const std::vector<std::string>& violations) {
  if (violations.empty()) return;
  std::string message = "after '" + std::string(stage) + "' the tree is broken:";
  for (const std::string& violation : violations) message += "\n  " + violation;
  throw std::logic_error(message);
}

/// Runs a recipe's stages one after the other.
class Pipeline {
 public:
  Pipeline(const Mesh& mesh, const Recipe& recipe, const BuildOptions& options)
      : mesh_(mesh), recipe_(recipe), options_(options) {}

  Bvh run() {
    StageRecorder recorder;
    const auto start = std::chrono::steady_clock::now();
    Bvh bvh;
    bvh.sah.leaf_limit = std::uint32_t(recipe_.layout.value("leaf"));
    check_indices(mesh_);
    Built built = build_tree(bvh.sah);
    bvh.report = {.recipe = recipe_.text(),
                  .faces = mesh_.faces.size(),
                  .references = built.references.size(),
                  .left_out_non_finite = built.references.left_out_non_finite,
                  .left_out_degenerate = built.references.left_out_degenerate};
    const std::string_view layout = recipe_.layout.word->name;
    Packed packed =
        find_function(kPackers, layout)(std::move(built), mesh_, bvh.sah, recipe_.layout);
    bvh.layout = std::move(packed.layout);
    bvh.report.sah = packed.sah;
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    bvh.report.seconds = elapsed.count();
    bvh.report.stages = recorder.stages();
    bvh.report.tree =
        std::visit([&](const auto& tree) { return compute_statistics(tree, bvh.sah); }, bvh.layout);
    if (options_.validate) require_sound(layout, bvh.validate(mesh_));
    return bvh;
  }

 private:
  References make_references() const {
    References references = create_references(mesh_);
    if (recipe_.splitter) {
      const auto percent = std::size_t(recipe_.splitter->value("budget"));
      split_references(references, mesh_, references.size() * percent / 100);
    }
    return references;
  }

  Built build_tree(const SahModel& sah) const {
    Built built{make_references(), {}};
    const std::string_view builder = recipe_.builder.word->name;
    built.tree = find_function(kBuilders, builder)(built.references, mesh_, sah, recipe_.builder);
    check(builder, built);
    for (const RecipeStage& stage : recipe_.optimizers) {
      find_function(kOptimizers, stage.word->name)(built.tree, sah, stage);
      check(stage.word->name, built);
    }
    return built;
  }

  void check(std::string_view stage, const Built& built) const {
    if (options_.validate) require_sound(stage, validate(built.tree, built.references));
  }

  const Mesh& mesh_;
  const Recipe& recipe_;
  const BuildOptions& options_;
};

}  // namespace

Bvh build(const Mesh& mesh, const Recipe& recipe, const BuildOptions& options) {
  return Pipeline(mesh, recipe, options).run();
}

Bvh build(const Mesh& mesh, std::string_view recipe, const BuildOptions& options) {
  return build(mesh, parse_recipe(recipe), options);
}

}  // namespace treelet
