#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "peers/contender.h"
#include "peers/scene_file.h"

namespace treelet::peers {

struct RacePlan {
  int builds = 5;
  int repeats = 7;  ///< of tracing each set of rays
};

/// Repeated timings of one thing that one contender did.
struct Timing {
  std::string kind;  ///< "build" or the kind of the rays
  std::string label;
  std::string recipe;
  std::size_t rays = 0;         ///< 0 for builds
  std::vector<double> samples;  ///< seconds
  JsonObject details;
};

using Progress = std::function<void(const std::string& step)>;
using Contenders = std::vector<std::unique_ptr<Contender>>;

/// Builds all trees over the scene and traces its rays with all, in turn: a machine that slows down
/// meanwhile treats all alike. The first round of each is not counted. Answers are compared with
/// the first contender's, which is best one of this library, whose hits are exact.
std::vector<Timing> race(const Contenders& contenders, const SceneFile& scene, const RacePlan& plan,
                         const Progress& progress);

}  // namespace treelet::peers
