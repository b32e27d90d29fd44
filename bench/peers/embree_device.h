#pragma once

#include <atomic>
#include <cstddef>
#include <string>

#include "peers/embree_api.h"

namespace treelet::peers {

/// One device of Embree, which builds on as many threads as the library uses and tells how much
/// memory it holds. Its errors become std::runtime_error.
class EmbreeDevice {
 public:
  EmbreeDevice();
  ~EmbreeDevice();
  EmbreeDevice(const EmbreeDevice&) = delete;
  EmbreeDevice& operator=(const EmbreeDevice&) = delete;

  RTCDevice get() const { return device_; }
  std::size_t held_bytes() const { return std::size_t(held_bytes_.load()); }
  /// As "4.4.0".
  std::string version() const;
  /// Throws what went wrong since the last check, if anything did.
  void check() const;

 private:
  static bool count_bytes(void* device, ssize_t bytes, bool is_done);
  static void keep_error(void* device, RTCError code, const char* message);

  RTCDevice device_;
  std::atomic<std::ptrdiff_t> held_bytes_ = 0;
  mutable std::string error_;
};

}  // namespace treelet::peers
