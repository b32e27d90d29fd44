#include "peers/bvh_contender.h"

#include <vector>

namespace treelet::peers {

JsonObject BvhContender::describe_tree() const {
  const BuildReport& report = bvh_->report;
  JsonObject stages;
  for (const StageTime& stage : report.stages) stages.add(stage.name, stage.seconds);
  JsonObject facts;
  facts.add("bytes", double(report.tree.bytes));
  facts.add("sah", report.sah);
  facts.add("layout_sah", report.tree.sah);
  facts.add("nodes", double(report.tree.nodes));
  facts.add("references", double(report.references));
  facts.add("stages", stages);
  return facts;
}

void BvhContender::answer(Query query, const RayBatch& rays, Answers& answers) const {
  if (query == Query::any) {
    bvh_->find_occluded(rays, answers.any_hits());
  } else {
    bvh_->intersect(rays, answers.hits());
  }
}

JsonObject BvhContender::count_work(const RayBatch& rays) const {
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

}  // namespace treelet::peers
