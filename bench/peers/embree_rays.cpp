#include "peers/embree_rays.h"

#include <treelet/core/parallel.h>

#include <algorithm>
#include <limits>

namespace treelet::peers {
namespace {

constexpr std::size_t kRaysPerTask = 1024;  // as query/intersect.cpp
constexpr std::size_t kPacket = 16;
static_assert(kRaysPerTask % kPacket == 0, "packets do not reach into the next task");

RTCRay embree_ray(const Ray& ray) {
  RTCRay result{};
  result.org_x = ray.origin.x;
  result.org_y = ray.origin.y;
  result.org_z = ray.origin.z;
  result.tnear = ray.t_min;
  result.dir_x = ray.direction.x;
  result.dir_y = ray.direction.y;
  result.dir_z = ray.direction.z;
  result.tfar = ray.t_max;
  result.mask = ~0u;
  return result;
}

Hit hit_of(const RTCRayHit& found) {
  if (found.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
  return {found.ray.tfar, std::int32_t(found.hit.primID), found.hit.u, found.hit.v};
}

/// Lanes beyond the rays that are left stay as they are.
void load_packet(RTCRayHit16& packet, const RayBatch& rays, std::size_t first, std::size_t count) {
  RTCRay16& to = packet.ray;
  for (std::size_t lane = 0; lane < count; ++lane) {
    const Ray ray = rays[first + lane];
    to.org_x[lane] = ray.origin.x;
    to.org_y[lane] = ray.origin.y;
    to.org_z[lane] = ray.origin.z;
    to.tnear[lane] = ray.t_min;
    to.dir_x[lane] = ray.direction.x;
    to.dir_y[lane] = ray.direction.y;
    to.dir_z[lane] = ray.direction.z;
    to.tfar[lane] = ray.t_max;
    packet.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
  }
}

Hit hit_of(const RTCRayHit16& found, std::size_t lane) {
  const RTCHit16& hit = found.hit;
  if (hit.geomID[lane] == RTC_INVALID_GEOMETRY_ID) return {};
  return {found.ray.tfar[lane], std::int32_t(hit.primID[lane]), hit.u[lane], hit.v[lane]};
}

void trace_packets(RTCScene scene, const RayBatch& rays, std::size_t begin, std::size_t end,
                   const HitArrays& hits) {
  RTCIntersectArguments arguments;
  arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  RTCRayHit16 packet{};
  std::fill_n(packet.ray.mask, kPacket, ~0u);
  for (std::size_t first = begin; first < end; first += kPacket) {
    const std::size_t count = std::min(kPacket, end - first);
    alignas(64) int valid[kPacket] = {};
    std::fill_n(valid, count, -1);
    load_packet(packet, rays, first, count);
    rtcIntersect16(valid, scene, &packet, &arguments);
    for (std::size_t lane = 0; lane < count; ++lane) hits.set(first + lane, hit_of(packet, lane));
  }
}

}  // namespace

void find_closest(RTCScene scene, const RayBatch& rays, const HitArrays& hits) {
  parallel_for_ranges(rays.size, kRaysPerTask, [&](std::size_t begin, std::size_t end) {
    RTCIntersectArguments arguments;
    RTCRayHit found{};
    for (std::size_t i = begin; i < end; ++i) {
      found.ray = embree_ray(rays[i]);
      found.hit.geomID = RTC_INVALID_GEOMETRY_ID;
      rtcIntersect1(scene, &found, &arguments);
      hits.set(i, hit_of(found));
    }
  });
}

void find_closest_in_packets(RTCScene scene, const RayBatch& rays, const HitArrays& hits) {
  parallel_for_ranges(rays.size, kRaysPerTask, [&](std::size_t begin, std::size_t end) {
    trace_packets(scene, rays, begin, end, hits);
  });
}

void find_occluded(RTCScene scene, const RayBatch& rays, std::span<bool> occluded) {
  constexpr float kOccluded = -std::numeric_limits<float>::infinity();
  parallel_for_ranges(rays.size, kRaysPerTask, [&](std::size_t begin, std::size_t end) {
    RTCOccludedArguments arguments;
    for (std::size_t i = begin; i < end; ++i) {
      RTCRay ray = embree_ray(rays[i]);
      rtcOccluded1(scene, &ray, &arguments);
      occluded[i] = ray.tfar == kOccluded;
    }
  });
}

}  // namespace treelet::peers
