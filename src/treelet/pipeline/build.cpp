#include <treelet/pipeline/build.h>

#include <array>
#include <chrono>
#include <stdexcept>

#include <treelet/build/hploc.h>
#include <treelet/build/lbvh.h>
#include <treelet/build/sweep.h>
#include <treelet/layout/leaf_collapse.h>
#include <treelet/layout/pack_bvh2.h>
#include <treelet/layout/pack_bvh8.h>
#include <treelet/optimize/treelet.h>
#include <treelet/primitive/split.h>
#include <treelet/tree/validate.h>

namespace treelet {
namespace {

using Builder = BinaryTree (*)(const References&, const RecipeStage&);
using Optimizer = void (*)(BinaryTree&, const SahModel&, const RecipeStage&);

BinaryTree run_lbvh(const References& references, const RecipeStage&) {
  return build_lbvh(references);
}

BinaryTree run_hploc(const References& references, const RecipeStage& stage) {
  return build_hploc(references, {.radius = int(stage.value("radius"))});
}

BinaryTree run_sweep(const References& references, const RecipeStage&) {
  return build_sweep(references);
}

void run_treelet(BinaryTree& tree, const SahModel& sah, const RecipeStage& stage) {
  const TreeletConfig config{.size = int(stage.value("size")),
                             .rounds = int(stage.value("rounds")),
                             .gamma = std::uint32_t(stage.value("gamma"))};
  restructure_treelets(tree, sah, config);
}

/// What a packer reads.
struct PackInput {
  const BinaryTree& tree;
  const References& references;
  const Mesh& mesh;
};
using Layout = decltype(Bvh::layout);
using Packer = Layout (*)(const PackInput&, const SahModel&, const RecipeStage&);

Layout run_bvh2(const PackInput& input, const SahModel& sah, const RecipeStage&) {
  return pack_bvh2(input.tree, input.references, input.mesh, sah);
}

Layout run_bvh8(const PackInput& input, const SahModel&, const RecipeStage& stage) {
  const WideCostModel model{.leaf_limit = std::uint32_t(stage.value("leaf"))};
  return pack_bvh8(input.tree, input.references, input.mesh, model);
}

template <class Function>
struct Entry {
  std::string_view word;
  Function run;
};

constexpr std::array<Entry<Builder>, 3> kBuilders{
    {{"lbvh", run_lbvh}, {"hploc", run_hploc}, {"sweep", run_sweep}}};
constexpr std::array<Entry<Optimizer>, 1> kOptimizers{{{"treelet", run_treelet}}};
constexpr std::array<Entry<Packer>, 2> kPackers{{{"bvh2", run_bvh2}, {"bvh8", run_bvh8}}};

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
    const References references = make_references();
    const BinaryTree tree = build_tree(references, bvh.sah);
    const std::string_view layout = recipe_.layout.word->name;
    bvh.layout =
        find_function(kPackers, layout)({tree, references, mesh_}, bvh.sah, recipe_.layout);
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    if (options_.validate) require_sound(layout, bvh.validate(mesh_));
    bvh.report = {
        .recipe = recipe_.text(),
        .stages = recorder.stages(),
        .seconds = elapsed.count(),
        .faces = mesh_.faces.size(),
        .references = references.size(),
        .left_out_non_finite = references.left_out_non_finite,
        .left_out_degenerate = references.left_out_degenerate,
        .sah = collapsed_sah_cost(tree, references, bvh.sah),
        .tree = std::visit([&](const auto& packed) { return compute_statistics(packed, bvh.sah); },
                           bvh.layout)};
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

  BinaryTree build_tree(const References& references, const SahModel& sah) const {
    const std::string_view builder = recipe_.builder.word->name;
    BinaryTree tree = find_function(kBuilders, builder)(references, recipe_.builder);
    check(builder, tree, references);
    for (const RecipeStage& stage : recipe_.optimizers) {
      find_function(kOptimizers, stage.word->name)(tree, sah, stage);
      check(stage.word->name, tree, references);
    }
    return tree;
  }

  void check(std::string_view stage, const BinaryTree& tree, const References& references) const {
    if (options_.validate) require_sound(stage, validate(tree, references));
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
