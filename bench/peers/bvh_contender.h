#pragma once

#include <optional>

#include <treelet/pipeline/bvh.h>

#include "peers/contender.h"

namespace treelet::peers {

/// A contender whose tree is a Bvh, whoever builds it: all are traced by the same code.
class BvhContender : public Contender {
 public:
  void build(const Mesh& mesh) final { bvh_ = build_bvh(mesh); }
  void drop() final { bvh_.reset(); }
  JsonObject describe_tree() const final;

  bool can_answer(Query query) const final { return query != Query::packets; }
  void answer(Query query, const RayBatch& rays, Answers& answers) const final;
  JsonObject count_work(const RayBatch& rays) const final;

 private:
  virtual Bvh build_bvh(const Mesh& mesh) = 0;

  std::optional<Bvh> bvh_;
};

}  // namespace treelet::peers
