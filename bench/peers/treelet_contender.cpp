#include "peers/treelet_contender.h"

#include <treelet/pipeline/build.h>

#include <optional>
#include <vector>

namespace treelet::peers {
namespace {

class TreeletContender final : public Contender {
 public:
  explicit TreeletContender(std::string_view recipe)
      : label_(recipe), recipe_(parse_recipe(recipe)) {}

  std::string label() const override { return label_; }
  std::string recipe() const override { return recipe_.text(); }

  void build(const Mesh& mesh) override { bvh_ = treelet::build(mesh, recipe_); }
  void drop() override { bvh_.reset(); }
  JsonObject describe_tree() const override;

  bool can_answer(Query query) const override { return query != Query::packets; }
  void answer(Query query, const RayBatch& rays, Answers& answers) const override;
  JsonObject count_work(const RayBatch& rays) const override;

 private:
  std::string label_;
  Recipe recipe_;
  std::optional<Bvh> bvh_;
};

JsonObject TreeletContender::describe_tree() const {
  const BuildReport& report = bvh_->report;
  JsonObject stages;
  for (const StageTime& stage : report.stages) stages.add(stage.name, stage.seconds);
  JsonObject facts;
  facts.add("bytes", double(report.tree.bytes));
  facts.add("sah", report.sah);
  facts.add("nodes", double(report.tree.nodes));
  facts.add("references", double(report.references));
  facts.add("stages", stages);
  return facts;
}

void TreeletContender::answer(Query query, const RayBatch& rays, Answers& answers) const {
  if (query == Query::any) {
    bvh_->find_occluded(rays, answers.any_hits());
  } else {
    bvh_->intersect(rays, answers.hits());
  }
}

JsonObject TreeletContender::count_work(const RayBatch& rays) const {
  std::vector<Work> work(rays.size);
  bvh_->count_work(rays, work);
  double nodes = 0, triangles = 0;
  for (const Work& ray : work) {
    nodes += ray.nodes;
    triangles += ray.triangles;
  }
  JsonObject counts;
  counts.add("nodes_per_ray", nodes / double(rays.size));
  counts.add("triangles_per_ray", triangles / double(rays.size));
  return counts;
}

}  // namespace

std::unique_ptr<Contender> make_treelet_contender(std::string_view recipe) {
  return std::make_unique<TreeletContender>(recipe);
}

}  // namespace treelet::peers
