#include "peers/embree_tree_contender.h"

#include <treelet/layout/pack_bvh8.h>

#include <utility>

#include "peers/bvh_contender.h"
#include "peers/embree_tree.h"

namespace treelet::peers {
namespace {

/// As the pipeline packs, for `> bvh8` with its defaults; the tree is let go before nodes are
/// written.
Bvh8 pack(BinaryTree tree, References references, const Mesh& mesh, const SahModel& sah,
          BuildReport& report) {
  WideCollapse collapse = collapse_wide(tree, references, {.leaf_limit = sah.leaf_limit}, sah);
  report.sah = collapse.sah;
  const Bvh8Plan plan = plan_bvh8(collapse, references, tree);
  Bvh8 layout = allocate_bvh8(plan);
  tree = {};
  references = {};
  collapse = {};
  write_bvh8(plan, mesh, layout);
  return layout;
}

class EmbreeTreeContender final : public BvhContender {
 public:
  explicit EmbreeTreeContender(const EmbreeTreeOptions& options) : options_(options) {}

  std::string label() const override { return options_.label(); }
  std::string recipe() const override { return options_.text() + " > bvh8"; }

 private:
  Bvh build_bvh(const Mesh& mesh) override;

  EmbreeTreeOptions options_;
  EmbreeDevice device_;
};

Bvh EmbreeTreeContender::build_bvh(const Mesh& mesh) {
  const StageRecorder recorder;
  Bvh bvh;
  bvh.sah.leaf_limit = WideCostModel{}.leaf_limit;
  check_indices(mesh);
  References references = create_references(mesh);
  BinaryTree tree = build_embree_tree(device_, references, mesh, options_);
  bvh.report = {.recipe = recipe(), .faces = mesh.faces.size(), .references = references.size()};
  bvh.layout = pack(std::move(tree), std::move(references), mesh, bvh.sah, bvh.report);
  bvh.report.stages = recorder.stages();
  bvh.report.tree = compute_statistics(std::get<Bvh8>(bvh.layout), bvh.sah);
  return bvh;
}

}  // namespace

std::unique_ptr<Contender> make_embree_tree_contender(std::string_view text) {
  return std::make_unique<EmbreeTreeContender>(parse_embree_tree_options(text));
}

}  // namespace treelet::peers
