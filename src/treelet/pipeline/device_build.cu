#include <treelet/pipeline/device_build.h>

#include <algorithm>
#include <array>
#include <string>
#include <string_view>

#include <treelet/core/cuda_error.h>
#include <treelet/tree/refit.h>
#include <treelet/core/launch.cuh>

namespace treelet::cuda {
namespace {

constexpr std::array<std::string_view, 5> kDeviceWords{"lbvh", "hploc", "treelet", "bvh2", "bvh8"};

void require_device_word(const RecipeStage& stage) {
  if (runs_on_device(stage.word->name)) return;
  std::string message = "'" + std::string(stage.word->name) +
                        "' runs on the CPU alone: build there and move the tree, or use one of";
  for (const std::string_view word : kDeviceWords) message += " " + std::string(word);
  throw CudaError(message);
}

bool builds_by_hploc(const Recipe& recipe) { return recipe.builder.word->name == "hploc"; }

TreeletConfig treelet_config(const RecipeStage& stage) {
  return {.size = int(stage.value("size")),
          .rounds = int(stage.value("rounds")),
          .gamma = std::uint32_t(stage.value("gamma"))};
}

/// Takes what each of `phases` takes, all from the same place: they come one after another.
template <class... Phases>
void share(Carver& carver, Phases&&... phases) {
  const std::size_t mark = carver.used();
  std::size_t end = mark;
  const auto take = [&](auto&& phase) {
    carver.rewind(mark);
    phase();
    end = std::max(end, carver.used());
  };
  (take(phases), ...);
  carver.rewind(end);
}

}  // namespace

bool runs_on_device(std::string_view recipe_word) {
  return std::find(kDeviceWords.begin(), kDeviceWords.end(), recipe_word) != kDeviceWords.end();
}

void require_device_words(const Recipe& recipe) {
  if (recipe.splitter) require_device_word(*recipe.splitter);
  require_device_word(recipe.builder);
  for (const RecipeStage& stage : recipe.optimizers) require_device_word(stage);
  require_device_word(recipe.layout);
}

BuildMemory carve_build(Carver& carver, std::uint32_t faces, const Recipe& recipe) {
  BuildMemory memory;
  memory.scene = carver.take<DeviceScene>(1);
  memory.summaries = carve_summaries(carver);
  memory.sah = carver.take<double>(1);
  memory.tree = {carver.take<BinaryNode>(2 * std::size_t(faces)),
                 memory.scene == nullptr ? nullptr : &memory.scene->reference_count, faces};
  const auto order_references = [&] {
    memory.order = carve_morton_order(carver, faces);
    share(
        carver, [&] { memory.sort = carve_sort_scratch(carver, faces); },
        [&] {
          if (builds_by_hploc(recipe)) {
            memory.hploc = carve_hploc_scratch(carver, faces);
          } else {
            memory.lbvh = carve_lbvh_scratch(carver, faces);
          }
        });
  };
  const auto restructure = [&] { memory.treelet = carve_treelet_buffers(carver, faces); };
  const auto pack = [&] {
    memory.cut = carve_cut(carver, faces);
    share(
        carver, [&] { memory.costs = carver.take<float>(2 * std::size_t(faces)); },
        [&] {
          if (recipe.layout.word->name == "bvh2") {
            memory.pack = carve_bvh2_scratch(carver, faces);
          } else {
            memory.pack = carve_bvh8_scratch(carver, faces);
          }
        });
  };
  share(carver, order_references, restructure, pack);
  return memory;
}

void DevicePipeline::begin(const char* stage) {
  if (stages_ != nullptr) stages_->begin(stage);
}

DeviceReferences DevicePipeline::references() const {
  return {mesh_, memory_.scene, nullptr, mesh_.face_count};
}

SahModel DevicePipeline::sah() const {
  SahModel model;
  model.leaf_limit = std::uint32_t(recipe_.layout.value("leaf"));
  return model;
}

void DevicePipeline::survey() {
  begin("survey the mesh");
  survey_mesh(mesh_, memory_.summaries, memory_.scene, stream_);
}

void DevicePipeline::run_builder() {
  begin("sort Morton codes");
  sort_along_morton_curve(references(), memory_.order, memory_.sort, stream_);
  if (builds_by_hploc(recipe_)) {
    begin("merge clusters");
    const HplocConfig config{.radius = int(recipe_.builder.value("radius"))};
    return build_hploc(references(), memory_.order, config, memory_.hploc, memory_.tree, stream_);
  }
  begin("emit LBVH and fit boxes");
  build_lbvh(references(), memory_.order, memory_.lbvh, memory_.tree, stream_);
}

void DevicePipeline::run_optimizer(const RecipeStage& stage) {
  begin("restructure treelets");
  restructure_treelets(memory_.tree, sah(), treelet_config(stage), memory_.treelet, stream_);
}

void DevicePipeline::plan_layout() {
  begin("cost of the tree");
  cut_tree(memory_.tree, memory_.cut, stream_);
  compute_costs(memory_.tree, memory_.cut, sah(), memory_.costs, stream_);
  normalize_cost(memory_.tree, memory_.costs, memory_.sah, stream_);
  begin("collapse");
  if (const auto* scratch = std::get_if<Bvh2Scratch>(&memory_.pack)) {
    plan_bvh2(memory_.tree, memory_.cut, sah(), *scratch, stream_);
  } else {
    const WideCostModel model{.leaf_limit = sah().leaf_limit};
    plan_bvh8(memory_.tree, memory_.cut, model, std::get<Bvh8Scratch>(memory_.pack), stream_);
  }
}

void DevicePipeline::write_layout(const DeviceBvh2& bvh) {
  begin("pack bvh2");
  write_bvh2(memory_.tree, mesh_, std::get<Bvh2Scratch>(memory_.pack), bvh, stream_);
}

void DevicePipeline::write_layout(const DeviceBvh8& bvh) {
  begin("pack bvh8");
  write_bvh8(memory_.tree, mesh_, std::get<Bvh8Scratch>(memory_.pack), bvh, stream_);
}

}  // namespace treelet::cuda
