#pragma once

#include <cstdint>

#include <treelet/core/launch.cuh>

namespace treelet::cuda {

/// lane_index(), but the compiler cannot know: else it keeps all that follows from the lane, a
/// whole schedule, in registers from one treelet to the next, and spills.
__device__ inline unsigned opaque_lane_index() {
  return __shfl_sync(kFullWarp, lane_index(), int(lane_index()));
}

/// The least value among this lane's group of so many neighbouring lanes.
template <int Lanes>
__device__ float least_of_lanes(float value) {
  for (int distance = Lanes / 2; distance > 0; distance /= 2) {
    value = fminf(value, __shfl_xor_sync(kFullWarp, value, distance));
  }
  return value;
}

template <int Lanes>
__device__ float largest_of_lanes(float value) {
  for (int distance = Lanes / 2; distance > 0; distance /= 2) {
    value = fmaxf(value, __shfl_xor_sync(kFullWarp, value, distance));
  }
  return value;
}

/// The first of the lanes for which `predicate` holds; kWarpSize where there is none.
__device__ inline int first_lane(bool predicate) {
  const int number = __ffs(int(__ballot_sync(kFullWarp, predicate)));
  return number == 0 ? kWarpSize : number - 1;
}

}  // namespace treelet::cuda
