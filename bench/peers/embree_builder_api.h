#pragma once

#include <cstddef>

#include "peers/embree_api.h"

// Embree 4's interface to its builders, which make trees of the caller's nodes: as embree_api.h.

extern "C" {

using RTCBVH = struct RTCBVHTy*;
using RTCThreadLocalAllocator = struct RTCThreadLocalAllocatorTy*;

enum RTCBuildFlags : int { RTC_BUILD_FLAG_NONE = 0 };

struct alignas(32) RTCBuildPrimitive {
  float lower_x, lower_y, lower_z;
  unsigned geomID;
  float upper_x, upper_y, upper_z;
  unsigned primID;
};

struct alignas(16) RTCBounds {
  float lower_x, lower_y, lower_z, align0;
  float upper_x, upper_y, upper_z, align1;
};

using RTCCreateNodeFunction = void* (*)(RTCThreadLocalAllocator allocator, unsigned children,
                                        void* user);
using RTCSetNodeChildrenFunction = void (*)(void* node, void** children, unsigned count,
                                            void* user);
using RTCSetNodeBoundsFunction = void (*)(void* node, const RTCBounds** bounds, unsigned count,
                                          void* user);
using RTCCreateLeafFunction = void* (*)(RTCThreadLocalAllocator allocator,
                                        const RTCBuildPrimitive* primitives, std::size_t count,
                                        void* user);
using RTCSplitPrimitiveFunction = void (*)(const RTCBuildPrimitive* primitive, unsigned axis,
                                           float position, RTCBounds* left, RTCBounds* right,
                                           void* user);
using RTCProgressMonitorFunction = bool (*)(void* user, double share);

/// Embree's own defaults, but for leaves of one primitive and depth without a limit.
struct RTCBuildArguments {
  std::size_t byteSize = sizeof(RTCBuildArguments);
  RTCBuildQuality buildQuality = RTC_BUILD_QUALITY_MEDIUM;
  RTCBuildFlags buildFlags = RTC_BUILD_FLAG_NONE;
  unsigned maxBranchingFactor = 2;
  unsigned maxDepth = 1024;
  unsigned sahBlockSize = 1;
  unsigned minLeafSize = 1;
  unsigned maxLeafSize = 1;
  float traversalCost = 1.0f;
  float intersectionCost = 1.0f;
  RTCBVH bvh = nullptr;
  RTCBuildPrimitive* primitives = nullptr;
  std::size_t primitiveCount = 0;
  std::size_t primitiveArrayCapacity = 0;
  RTCCreateNodeFunction createNode = nullptr;
  RTCSetNodeChildrenFunction setNodeChildren = nullptr;
  RTCSetNodeBoundsFunction setNodeBounds = nullptr;
  RTCCreateLeafFunction createLeaf = nullptr;
  RTCSplitPrimitiveFunction splitPrimitive = nullptr;
  RTCProgressMonitorFunction buildProgress = nullptr;
  void* userPtr = nullptr;
};

RTCBVH rtcNewBVH(RTCDevice device);
void* rtcBuildBVH(const RTCBuildArguments* arguments);
void* rtcThreadLocalAlloc(RTCThreadLocalAllocator allocator, std::size_t bytes, std::size_t align);
void rtcReleaseBVH(RTCBVH bvh);
}

static_assert(sizeof(RTCBuildPrimitive) == 32 && offsetof(RTCBuildPrimitive, primID) == 28);
static_assert(sizeof(RTCBounds) == 32 && offsetof(RTCBounds, upper_x) == 16);
static_assert(offsetof(RTCBuildArguments, bvh) == 48);
static_assert(sizeof(RTCBuildArguments) == 136);
