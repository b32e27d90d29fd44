#include "peers/agreement.h"

#include <algorithm>
#include <cmath>

namespace treelet::peers {
namespace {

bool agree(float expected, float actual) {
  if (expected == actual) return true;  // also two misses
  if (!std::isfinite(expected) || !std::isfinite(actual)) return false;
  return std::abs(expected - actual) <= kRelativeTolerance * std::max(expected, actual);
}

}  // namespace

double share_of_differences(Query query, const Answers& expected, const Answers& actual) {
  const std::size_t rays = expected.t.size();
  std::size_t differing = 0;
  for (std::size_t i = 0; i < rays; ++i) {
    const bool is_same = query == Query::any ? expected.occluded[i] == actual.occluded[i]
                                             : agree(expected.t[i], actual.t[i]);
    differing += is_same ? 0 : 1;
  }
  return rays == 0 ? 0.0 : double(differing) / double(rays);
}

}  // namespace treelet::peers
