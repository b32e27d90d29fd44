#pragma once

#include <variant>

#include <treelet/build/hploc.h>
#include <treelet/build/lbvh.h>
#include <treelet/core/carver.h>
#include <treelet/core/device_stages.h>
#include <treelet/core/stream.h>
#include <treelet/layout/device_face_counts.h>
#include <treelet/layout/device_pack.h>
#include <treelet/optimize/treelet.h>
#include <treelet/pipeline/recipe.h>
#include <treelet/primitive/device_references.h>
#include <treelet/primitive/device_sort.h>
#include <treelet/primitive/morton_order.h>
#include <treelet/primitive/split.h>
#include <treelet/tree/device_cut.h>
#include <treelet/tree/device_tree.h>
#include <treelet/tree/sah.h>

// A build on the device as what is enqueued on a stream, over memory that is there already. Nothing
// here waits or allocates.

namespace treelet::cuda {

/// All that a build needs besides the mesh and the layout's own arrays. Stages that follow each
/// other share memory:
///
///     | scene, sah | tree | split references | split scratch     where split
///     | scene, sah | tree | codes, order | sort scratch          build order
///     |            |      |              | lbvh or hploc scratch build
///     |            |      | cut | treelet costs                  restructure
///     |            |      | cut | face counts | their scratch    count faces, where split
///     |            |      | cut | face counts | collapse entries pack
struct BuildMemory {
  DeviceScene* scene = nullptr;
  MeshSummary* summaries = nullptr;
  double* sah = nullptr;
  DeviceTree tree;
  Reference* split = nullptr;  ///< null where no splitter is in the recipe
  SplitScratch split_scratch;
  DeviceMortonOrder order;
  SortScratch sort;
  LbvhScratch lbvh;
  HplocScratch hploc;
  DeviceCut cut;
  SubtreeFaces faces;  ///< null where no splitter is in the recipe
  FaceCountScratch face_counts;
  float* costs = nullptr;
  TreeletBuffers treelet;
  std::variant<Bvh2Scratch, Bvh8Scratch, CwbvhScratch> pack;

  const LayoutSize* planned_size() const {
    return std::visit([](const auto& scratch) { return scratch.size; }, pack);
  }
};

/// Lays the memory out for a mesh of at most `faces` faces.
BuildMemory carve_build(Carver& carver, std::uint32_t faces, const Recipe& recipe);

/// Recipe words that have a device version.
bool runs_on_device(std::string_view recipe_word);
/// Throws CudaError that names the first word of the recipe that has none.
void require_device_words(const Recipe& recipe);

/// Runs a recipe's stages one after the other. `stages` may be null: nobody listens.
class DevicePipeline {
 public:
  DevicePipeline(const DeviceMesh& mesh, const Recipe& recipe, const BuildMemory& memory,
                 Stream stream, DeviceStages* stages)
      : mesh_(mesh), recipe_(recipe), memory_(memory), stream_(stream), stages_(stages) {}

  /// From triangles to a binary tree with all of the recipe's optimizers. Calls
  /// check(word) after each stage that leaves a tree.
  template <class Check>
  void build_tree(Check&& check) {
    survey();
    split();
    run_builder();
    check(recipe_.builder.word->name);
    for (const RecipeStage& stage : recipe_.optimizers) {
      run_optimizer(stage);
      check(stage.word->name);
    }
  }

  /// Finds out what the layout takes, and the tree's SAH.
  void plan_layout();
  void write_layout(const DeviceBvh2& bvh);
  void write_layout(const DeviceBvh8& bvh);
  void write_layout(const DeviceCwbvh& bvh);

  DeviceReferences references() const;
  SahModel sah() const;

 private:
  PackInput pack_input() const;
  void plan(const Bvh2Scratch& scratch);
  void plan(const Bvh8Scratch& scratch);
  void plan(const CwbvhScratch& scratch);
  void begin(const char* stage);
  void survey();
  void split();
  void run_builder();
  void run_optimizer(const RecipeStage& stage);

  const DeviceMesh& mesh_;
  const Recipe& recipe_;
  const BuildMemory& memory_;
  Stream stream_;
  DeviceStages* stages_;
};

}  // namespace treelet::cuda
