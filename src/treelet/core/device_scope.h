#pragma once

namespace treelet::cuda {

/// The device that this thread allocates on.
int current_device();

/// Makes the device that holds some memory the current one while it lives. Memory that no device
/// holds is a CudaError that names it by `what`.
class DeviceScope {
 public:
  DeviceScope(const void* memory, const char* what);
  ~DeviceScope();
  DeviceScope(const DeviceScope&) = delete;
  DeviceScope& operator=(const DeviceScope&) = delete;

  int device() const { return device_; }

 private:
  int device_ = -1;
  int outer_ = -1;
};

}  // namespace treelet::cuda
