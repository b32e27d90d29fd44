#include <treelet/pipeline/build.h>

#include <array>
#include <chrono>
#include <stdexcept>
#include <utility>

#include <treelet/build/binned.h>
#include <treelet/build/grid_sah.h>
#include <treelet/build/hlbvh.h>
#include <treelet/build/hploc.h>
#include <treelet/build/lbvh.h>
#include <treelet/build/ploc.h>
#include <treelet/build/sbvh.h>
#include <treelet/build/sweep.h>
#include <treelet/layout/collapse_lbvh.h>
#include <treelet/layout/leaf_collapse.h>
#include <treelet/layout/pack_bvh2.h>
#include <treelet/layout/pack_bvh8.h>
#include <treelet/layout/pack_cwbvh.h>
#include <treelet/optimize/agglomeration.h>
#include <treelet/optimize/insertion.h>
#include <treelet/optimize/reinsertion.h>
#include <treelet/optimize/rotation.h>
#include <treelet/optimize/treelet.h>
#include <treelet/pipeline/split_trial.h>
#include <treelet/primitive/split.h>
#include <treelet/tree/validate.h>
#include <treelet/tree/violations.h>

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

BinaryTree run_ploc(References& references, const Mesh&, const SahModel&,
                    const RecipeStage& stage) {
  return build_ploc(references, {.radius = int(stage.value("radius"))});
}

BinaryTree run_hlbvh(References& references, const Mesh&, const SahModel&,
                     const RecipeStage& stage) {
  return build_hlbvh(references,
                     {.bits = int(stage.value("bits")), .bins = int(stage.value("bins"))});
}

BinaryTree run_grid_sah(References& references, const Mesh&, const SahModel&,
                        const RecipeStage& stage) {
  return build_grid_sah(references,
                        {.bits = int(stage.value("bits")), .bins = int(stage.value("bins"))});
}

BinaryTree run_binned(References& references, const Mesh&, const SahModel&,
                      const RecipeStage& stage) {
  return build_binned(references, {.bins = int(stage.value("bins"))});
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

void run_reinsert(BinaryTree& tree, const SahModel& sah, const RecipeStage& stage) {
  reinsert_nodes(tree, sah,
                 {.percent = float(stage.value("percent")), .rounds = int(stage.value("rounds"))});
}

void run_insert(BinaryTree& tree, const SahModel& sah, const RecipeStage& stage) {
  insert_nodes(tree, sah,
               {.percent = float(stage.value("percent")),
                .batches = int(stage.value("batches")),
                .seed = std::uint32_t(stage.value("seed"))});
}

void run_rotate(BinaryTree& tree, const SahModel& sah, const RecipeStage& stage) {
  rotate_nodes(tree, sah,
               {.rounds = int(stage.value("rounds")),
                .anneal = int(stage.value("anneal")),
                .seed = std::uint32_t(stage.value("seed"))});
}

void run_agglomerate(BinaryTree& tree, const SahModel& sah, const RecipeStage& stage) {
  agglomerate_treelets(tree, sah,
                       {.size = int(stage.value("size")), .rounds = int(stage.value("rounds"))});
}

/// A tree and what it was built over. A packer takes both, and lets go of them when it can.
struct Built {
  References references;
  BinaryTree tree;
  bool is_to_be_emitted = false;  ///< the tree is an LBVH that has been left to the packer
};

using Layout = decltype(Bvh::layout);
struct Packed {
  Layout layout;
  double sah;  ///< of the binary tree
};
using Packer = Packed (*)(Built, const Mesh&, const SahModel&, const RecipeStage&);

Packed run_bvh2(Built built, const Mesh& mesh, const SahModel& sah, const RecipeStage&) {
  const LeafCollapse collapse = collapse_leaves(built.tree, built.references, sah);
  return {lay_out_bvh2(built.tree, built.references, mesh, collapse), collapse.sah};
}

/// Of an LBVH that nothing has been decided about, the tree itself is never written.
WideCollapse collapse_for_bvh8(const Built& built, const SahModel& sah, const RecipeStage& stage) {
  const WideCostModel model{.leaf_limit = std::uint32_t(stage.value("leaf"))};
  check_bvh8_model(model);
  return built.is_to_be_emitted ? collapse_lbvh(built.references, model, sah)
                                : collapse_wide(built.tree, built.references, model, sah);
}

Packed run_bvh8(Built built, const Mesh& mesh, const SahModel& sah, const RecipeStage& stage) {
  WideCollapse collapse = collapse_for_bvh8(built, sah, stage);
  const Bvh8Plan plan = plan_bvh8(collapse, built.references, built.tree);
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
  const WideCollapse collapse = collapse_wide(built.tree, built.references, model.checked(), sah);
  return {lay_out_cwbvh(built.tree, built.references, mesh, collapse), collapse.sah};
}

template <class Function>
struct Entry {
  std::string_view word;
  Function run;
};

constexpr std::array<Entry<Builder>, 8> kBuilders{{{"lbvh", run_lbvh},
                                                   {"hploc", run_hploc},
                                                   {"ploc", run_ploc},
                                                   {"hlbvh", run_hlbvh},
                                                   {"gridsah", run_grid_sah},
                                                   {"binned", run_binned},
                                                   {"sweep", run_sweep},
                                                   {"sbvh", run_sbvh}}};
constexpr std::array<Entry<Optimizer>, 5> kOptimizers{{{"treelet", run_treelet},
                                                       {"reinsert", run_reinsert},
                                                       {"insert", run_insert},
                                                       {"rotate", run_rotate},
                                                       {"atr", run_agglomerate}}};
constexpr std::array<Entry<Packer>, 3> kPackers{
    {{"bvh2", run_bvh2}, {"bvh8", run_bvh8}, {"cwbvh", run_cwbvh}}};

template <class Table>
auto find_function(const Table& table, std::string_view word) {
  for (const auto& entry : table) {
    if (entry.word == word) return entry.run;
  }
  throw std::logic_error("no function for the recipe word '" + std::string(word) + "'");
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
    built.is_to_be_emitted = may_emit_while_packing(built.references);
    if (built.is_to_be_emitted) return built;
    built.tree = find_function(kBuilders, builder)(built.references, mesh_, sah, recipe_.builder);
    check(builder, built);
    for (const RecipeStage& stage : recipe_.optimizers) {
      find_function(kOptimizers, stage.word->name)(built.tree, sah, stage);
      check(stage.word->name, built);
    }
    return built;
  }

  /// The fast way of `lbvh > bvh8`: the same layout without the tree between.
  bool may_emit_while_packing(const References& references) const {
    return recipe_.builder.word->name == "lbvh" && recipe_.optimizers.empty() &&
           recipe_.layout.word->name == "bvh8" && !references.may_repeat_faces &&
           !options_.validate;
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
  if (tries_splitting(recipe)) return build_by_trial(mesh, recipe, options);
  return Pipeline(mesh, recipe, options).run();
}

Bvh build(const Mesh& mesh, std::string_view recipe, const BuildOptions& options) {
  return build(mesh, parse_recipe(recipe), options);
}

}  // namespace treelet
