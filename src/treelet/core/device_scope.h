#pragma once

namespace treelet::cuda {

/// The device that this thread allocates on.
int current_device();

/// The device that holds some memory. Memory that none holds is a CudaError that names it by
/// `what`.
int device_of(const void* memory, const char* what);

/// Makes a device the current one while it lives.
class DeviceScope {
 public:
  explicit DeviceScope(int device);
  ~DeviceScope();
  DeviceScope(const DeviceScope&) = delete;
  DeviceScope& operator=(const DeviceScope&) = delete;

 private:
  int device_;
  int outer_;
};

}  // namespace treelet::cuda
