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

constexpr std::array<std::string_view, 7> kDeviceWords{"presplit", "lbvh", "hploc", "treelet",
                                                       "bvh2",     "bvh8", "cwbvh"};

void require_device_word(const RecipeStage& stage) {
  if (runs_on_device(stage.word->name)) return;
  std::string message = "'";
  message.append(stage.word->name);
  message.append("' runs on the CPU alone: build there and move the tree, or use one of");
  for (const std::string_view word : kDeviceWords) message.append(" ").append(word);
  throw CudaError(message);
}

bool builds_by_hploc(const Recipe& recipe) { return recipe.builder.word->name == "hploc"; }

TreeletConfig treelet_config(const RecipeStage& stage) {
  return {.size = int(stage.value("size")),
          .rounds = int(stage.value("rounds")),
          .gamma = std::uint32_t(stage.value("gamma"))};
}

std::uint32_t split_percent(const Recipe& recipe) {
  return std::uint32_t(recipe.splitter->value("budget"));
}

decltype(BuildMemory::pack) carve_pack_scratch(Carver& carver, std::string_view layout,
                                               std::uint32_t capacity) {
  if (layout == "bvh2") return carve_bvh2_scratch(carver, capacity);
  if (layout == "bvh8") return carve_bvh8_scratch(carver, capacity);
  return carve_cwbvh_scratch(carver, capacity);
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
  const std::uint32_t capacity =
      recipe.splitter ? split_capacity(faces, split_percent(recipe)) : faces;
  BuildMemory memory;
  memory.scene = carver.take<DeviceScene>(1);
  memory.summaries = carve_summaries(carver);
  memory.sah = carver.take<double>(1);
  memory.tree = {carver.take<BinaryNode>(2 * std::size_t(capacity)),
                 memory.scene == nullptr ? nullptr : &memory.scene->reference_count, capacity};
  if (recipe.splitter) memory.split = carver.take<Reference>(capacity);
  const auto split = [&] {
    if (recipe.splitter) memory.split_scratch = carve_split_scratch(carver, faces);
  };
  const auto order_references = [&] {
    memory.order = carve_morton_order(carver, capacity);
    share(
        carver, [&] { memory.sort = carve_sort_scratch(carver, capacity); },
        [&] {
          if (builds_by_hploc(recipe)) {
            memory.hploc = carve_hploc_scratch(carver, capacity);
          } else {
            memory.lbvh = carve_lbvh_scratch(carver, capacity);
          }
        });
  };
  const auto restructure = [&] { memory.treelet = carve_treelet_buffers(carver, capacity); };
  const auto pack = [&] {
    memory.cut = carve_cut(carver, capacity);
    if (recipe.splitter) memory.faces = carve_subtree_faces(carver, capacity);
    share(
        carver,
        [&] {
          if (recipe.splitter) memory.face_counts = carve_face_count_scratch(carver, capacity);
        },
        [&] { memory.costs = carver.take<float>(2 * std::size_t(capacity)); },
        [&] { memory.pack = carve_pack_scratch(carver, recipe.layout.word->name, capacity); });
  };
  share(carver, split, order_references, restructure, pack);
  return memory;
}

void DevicePipeline::begin(const char* stage) {
  if (stages_ != nullptr) stages_->begin(stage);
}

DeviceReferences DevicePipeline::references() const {
  return {mesh_, memory_.scene, memory_.split, memory_.tree.capacity};
}

SahModel DevicePipeline::sah() const {
  SahModel model;
  model.leaf_limit = std::uint32_t(recipe_.layout.value("leaf"));
  return model;
}

PackInput DevicePipeline::pack_input() const {
  return {memory_.tree, memory_.cut, references(), memory_.faces};
}

void DevicePipeline::survey() {
  begin("survey the mesh");
  survey_mesh(mesh_, memory_.summaries, memory_.scene, stream_);
}

void DevicePipeline::split() {
  if (!recipe_.splitter) return;
  begin("split triangles");
  split_references(mesh_, split_percent(recipe_), memory_.split_scratch, memory_.scene,
                   memory_.split, stream_);
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
  if (recipe_.splitter) {
    count_faces(memory_.tree, memory_.cut, references(), memory_.face_counts, memory_.faces,
                stream_);
  }
  compute_costs(memory_.tree, memory_.cut, memory_.faces, sah(), memory_.costs, stream_);
  normalize_cost(memory_.tree, memory_.costs, memory_.sah, stream_);
  begin("collapse");
  std::visit([&](const auto& scratch) { plan(scratch); }, memory_.pack);
}

void DevicePipeline::plan(const Bvh2Scratch& scratch) {
  plan_bvh2(pack_input(), sah(), scratch, stream_);
}

void DevicePipeline::plan(const Bvh8Scratch& scratch) {
  plan_bvh8(pack_input(), {.leaf_limit = sah().leaf_limit}, scratch, stream_);
}

void DevicePipeline::plan(const CwbvhScratch& scratch) {
  plan_cwbvh(pack_input(), {.leaf_limit = sah().leaf_limit}, scratch, stream_);
}

void DevicePipeline::write_layout(const DeviceBvh2& bvh) {
  begin("pack bvh2");
  write_bvh2(pack_input(), std::get<Bvh2Scratch>(memory_.pack), bvh, stream_);
}

void DevicePipeline::write_layout(const DeviceBvh8& bvh) {
  begin("pack bvh8");
  write_bvh8(pack_input(), std::get<Bvh8Scratch>(memory_.pack), bvh, stream_);
}

void DevicePipeline::write_layout(const DeviceCwbvh& bvh) {
  begin("pack cwbvh");
  write_cwbvh(pack_input(), std::get<CwbvhScratch>(memory_.pack), bvh, stream_);
}

}  // namespace treelet::cuda
