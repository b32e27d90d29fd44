#pragma once

#include <memory>
#include <string>
#include <string_view>

#include <treelet/mesh/mesh.h>
#include <treelet/query/ray_batch.h>

#include "peers/answers.h"
#include "peers/json.h"

namespace treelet::peers {

/// What builds a tree over a mesh and traces rays through it. All use the library's threads.
class Contender {
 public:
  virtual ~Contender() = default;

  /// How tables call it.
  virtual std::string label() const = 0;
  /// What it was made from, with every argument written out.
  virtual std::string recipe() const = 0;

  /// From the caller's arrays to a tree that can be traced; this is timed. The mesh must stay, and
  /// four bytes behind its last vertex must be readable.
  virtual void build(const Mesh& mesh) = 0;
  /// Gives the tree's memory back, if there is one.
  virtual void drop() = 0;
  /// Bytes that the tree keeps beside the caller's arrays, and what else is known of it.
  virtual JsonObject describe_tree() const = 0;

  virtual bool can_answer(Query query) const = 0;
  /// This is timed, too.
  virtual void answer(Query query, const RayBatch& rays, Answers& answers) const = 0;
  /// What finding the closest hits takes, on average: empty where it cannot be counted.
  virtual JsonObject count_work(const RayBatch& rays) const = 0;
};

/// From "embree:high", "embree:low+robust" and so on, from "embree-tree:high", "embree-tree:low"
/// and so on, or from a recipe of treelet. Throws std::invalid_argument for a text that is none.
std::unique_ptr<Contender> make_contender(std::string_view text);

}  // namespace treelet::peers
