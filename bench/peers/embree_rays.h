#pragma once

#include <treelet/query/ray_batch.h>

#include "peers/answers.h"
#include "peers/embree_api.h"

namespace treelet::peers {

// Rays from arrays into Embree's structures and hits back into arrays, in tasks of as many rays as
// the library's own and on the same threads: only the tracing differs.

void find_closest(RTCScene scene, const RayBatch& rays, const HitArrays& hits);
/// Sixteen rays that lie side by side a packet.
void find_closest_in_packets(RTCScene scene, const RayBatch& rays, const HitArrays& hits);
void find_occluded(RTCScene scene, const RayBatch& rays, std::span<bool> occluded);

}  // namespace treelet::peers
