#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <treelet/query/intersect.h>

namespace treelet::peers {

/// What is asked of a set of rays.
enum class Query {
  closest,  ///< ray by ray
  packets,  ///< closest, sixteen rays at a time
  any,      ///< whether there is a hit
};

/// Room for the answers to a set of rays, the same arrays for every contender.
struct Answers {
  std::vector<float> t, u, v;
  std::vector<std::int32_t> face;
  std::unique_ptr<bool[]> occluded;

  explicit Answers(std::size_t rays)
      : t(rays), u(rays), v(rays), face(rays), occluded(new bool[rays]) {}

  HitArrays hits() { return {t.data(), face.data(), u.data(), v.data()}; }
  std::span<bool> any_hits() { return {occluded.get(), t.size()}; }
};

}  // namespace treelet::peers
