#include "peers/embree_device.h"

#include <treelet/core/parallel.h>

#include <stdexcept>
#include <utility>

namespace treelet::peers {

EmbreeDevice::EmbreeDevice()
    : device_(rtcNewDevice(("threads=" + std::to_string(thread_count())).c_str())) {
  if (device_ == nullptr) throw std::runtime_error("Embree does not start on this machine");
  rtcSetDeviceErrorFunction(device_, keep_error, this);
  rtcSetDeviceMemoryMonitorFunction(device_, count_bytes, this);
}

EmbreeDevice::~EmbreeDevice() { rtcReleaseDevice(device_); }

std::string EmbreeDevice::version() const {
  const ssize_t number = rtcGetDeviceProperty(device_, RTC_DEVICE_PROPERTY_VERSION);
  return std::to_string(number / 10000) + "." + std::to_string(number / 100 % 100) + "." +
         std::to_string(number % 100);
}

void EmbreeDevice::check() const {
  if (!error_.empty()) throw std::runtime_error("Embree: " + std::exchange(error_, {}));
}

// Called once an allocation, before or after it: whichever it is, the bytes count once.
bool EmbreeDevice::count_bytes(void* device, ssize_t bytes, bool /*is_done*/) {
  static_cast<EmbreeDevice*>(device)->held_bytes_ += bytes;
  return true;
}

void EmbreeDevice::keep_error(void* device, RTCError, const char* message) {
  static_cast<EmbreeDevice*>(device)->error_ = message;
}

}  // namespace treelet::peers
