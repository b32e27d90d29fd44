#pragma once

#include "peers/answers.h"

namespace treelet::peers {

/// Two closest hits agree when their t are this close to each other, relative to the larger; the
/// faces may differ, as they do where a ray meets an edge. Single precision and a triangle seen
/// from the side make errors of 1e-5.
inline constexpr float kRelativeTolerance = 1e-4f;

/// The share of rays whose answers differ, hit against miss included.
double share_of_differences(Query query, const Answers& expected, const Answers& actual);

/// The share of rays whose answers differ in any bit of t, face, u or v. Nothing between trees that
/// this library traces: its hits are exact.
double share_of_unequal_bits(Query query, const Answers& expected, const Answers& actual);

}  // namespace treelet::peers
