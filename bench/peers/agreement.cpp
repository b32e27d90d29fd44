#include "peers/agreement.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

namespace treelet::peers {
namespace {

bool agree(float expected, float actual) {
  if (expected == actual) return true;  // also two misses
  if (!std::isfinite(expected) || !std::isfinite(actual)) return false;
  return std::abs(expected - actual) <= kRelativeTolerance * std::max(expected, actual);
}

bool are_same_bits(float a, float b) {
  return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b);
}

/// Of rays for which is_same(ray) is false.
template <class IsSame>
double share_of_others(std::size_t rays, IsSame&& is_same) {
  std::size_t others = 0;
  for (std::size_t i = 0; i < rays; ++i) others += is_same(i) ? 0 : 1;
  return rays == 0 ? 0.0 : double(others) / double(rays);
}

}  // namespace

double share_of_differences(Query query, const Answers& expected, const Answers& actual) {
  return share_of_others(expected.t.size(), [&](std::size_t i) {
    return query == Query::any ? expected.occluded[i] == actual.occluded[i]
                               : agree(expected.t[i], actual.t[i]);
  });
}

double share_of_unequal_bits(Query query, const Answers& expected, const Answers& actual) {
  return share_of_others(expected.t.size(), [&](std::size_t i) {
    if (query == Query::any) return expected.occluded[i] == actual.occluded[i];
    return expected.face[i] == actual.face[i] && are_same_bits(expected.t[i], actual.t[i]) &&
           are_same_bits(expected.u[i], actual.u[i]) && are_same_bits(expected.v[i], actual.v[i]);
  });
}

}  // namespace treelet::peers
