#pragma once

#include <sys/types.h>

#include <cstddef>

// The part of Embree 4's C interface that is raced here, after its API reference: the wheel that
// carries the library has no headers. Names, values and layouts are Embree's.

extern "C" {

using RTCDevice = struct RTCDeviceTy*;
using RTCScene = struct RTCSceneTy*;
using RTCGeometry = struct RTCGeometryTy*;

enum RTCError : int { RTC_ERROR_NONE = 0 };
enum RTCDeviceProperty : int { RTC_DEVICE_PROPERTY_VERSION = 0 };
enum RTCBuildQuality : int {
  RTC_BUILD_QUALITY_LOW = 0,
  RTC_BUILD_QUALITY_MEDIUM = 1,
  RTC_BUILD_QUALITY_HIGH = 2
};
enum RTCSceneFlags : int {
  RTC_SCENE_FLAG_NONE = 0,
  RTC_SCENE_FLAG_COMPACT = 1 << 1,
  RTC_SCENE_FLAG_ROBUST = 1 << 2
};
enum RTCGeometryType : int { RTC_GEOMETRY_TYPE_TRIANGLE = 0 };
enum RTCBufferType : int { RTC_BUFFER_TYPE_INDEX = 0, RTC_BUFFER_TYPE_VERTEX = 1 };
enum RTCFormat : int { RTC_FORMAT_UINT3 = 0x5003, RTC_FORMAT_FLOAT3 = 0x9003 };
enum RTCRayQueryFlags : int {
  RTC_RAY_QUERY_FLAG_INCOHERENT = 0,
  RTC_RAY_QUERY_FLAG_COHERENT = 1 << 16
};
inline constexpr int RTC_FEATURE_FLAG_ALL = -1;
inline constexpr unsigned RTC_INVALID_GEOMETRY_ID = unsigned(-1);

struct alignas(16) RTCRay {
  float org_x, org_y, org_z, tnear;
  float dir_x, dir_y, dir_z, time;
  float tfar;
  unsigned mask, id, flags;
};

/// Ends in instance numbers, how many depends on how Embree was built: here is room for more than
/// any build is known to write.
struct alignas(16) RTCHit {
  float Ng_x, Ng_y, Ng_z;
  float u, v;
  unsigned primID, geomID;
  unsigned instances[9];
};

struct RTCRayHit {
  RTCRay ray;
  RTCHit hit;
};

struct alignas(64) RTCRay16 {
  float org_x[16], org_y[16], org_z[16], tnear[16];
  float dir_x[16], dir_y[16], dir_z[16], time[16];
  float tfar[16];
  unsigned mask[16], id[16], flags[16];
};

/// As RTCHit: ends in instance numbers and room for more.
struct alignas(64) RTCHit16 {
  float Ng_x[16], Ng_y[16], Ng_z[16];
  float u[16], v[16];
  unsigned primID[16], geomID[16];
  unsigned instances[9][16];
};

struct RTCRayHit16 {
  RTCRay16 ray;
  RTCHit16 hit;
};

/// Ends in a field that only builds for curves of minimal width have: room for it.
struct RTCIntersectArguments {
  RTCRayQueryFlags flags = RTC_RAY_QUERY_FLAG_INCOHERENT;
  int feature_mask = RTC_FEATURE_FLAG_ALL;
  void* context = nullptr;
  void* filter = nullptr;
  void* intersect = nullptr;
  float min_width_distance_factor = 0.0f;
};
using RTCOccludedArguments = RTCIntersectArguments;  // same fields

using RTCErrorFunction = void (*)(void* user, RTCError code, const char* message);
using RTCMemoryMonitorFunction = bool (*)(void* user, ssize_t bytes, bool post);

RTCDevice rtcNewDevice(const char* config);
void rtcReleaseDevice(RTCDevice device);
RTCError rtcGetDeviceError(RTCDevice device);
ssize_t rtcGetDeviceProperty(RTCDevice device, RTCDeviceProperty property);
void rtcSetDeviceErrorFunction(RTCDevice device, RTCErrorFunction function, void* user);
void rtcSetDeviceMemoryMonitorFunction(RTCDevice device, RTCMemoryMonitorFunction function,
                                       void* user);

RTCScene rtcNewScene(RTCDevice device);
void rtcReleaseScene(RTCScene scene);
void rtcSetSceneBuildQuality(RTCScene scene, RTCBuildQuality quality);
void rtcSetSceneFlags(RTCScene scene, RTCSceneFlags flags);
unsigned rtcAttachGeometry(RTCScene scene, RTCGeometry geometry);
void rtcCommitScene(RTCScene scene);

RTCGeometry rtcNewGeometry(RTCDevice device, RTCGeometryType type);
void rtcReleaseGeometry(RTCGeometry geometry);
void rtcSetGeometryBuildQuality(RTCGeometry geometry, RTCBuildQuality quality);
void rtcSetSharedGeometryBuffer(RTCGeometry geometry, RTCBufferType type, unsigned slot,
                                RTCFormat format, const void* data, std::size_t byte_offset,
                                std::size_t byte_stride, std::size_t count);
void rtcCommitGeometry(RTCGeometry geometry);

void rtcIntersect1(RTCScene scene, RTCRayHit* ray_hit, RTCIntersectArguments* arguments);
void rtcOccluded1(RTCScene scene, RTCRay* ray, RTCOccludedArguments* arguments);
void rtcIntersect16(const int* valid, RTCScene scene, RTCRayHit16* ray_hit,
                    RTCIntersectArguments* arguments);
}

static_assert(sizeof(RTCRay) == 48 && offsetof(RTCRay, tfar) == 32);
static_assert(offsetof(RTCRayHit, hit) == 48 && offsetof(RTCHit, instances) == 28);
static_assert(sizeof(RTCRay16) == 768 && offsetof(RTCRay16, tfar) == 512);
static_assert(offsetof(RTCRayHit16, hit) == 768 && offsetof(RTCHit16, instances) == 448);
static_assert(offsetof(RTCIntersectArguments, context) == 8);
