#include <treelet/core/device_scope.h>

#include <treelet/core/no_cuda.h>

namespace treelet::cuda {

int current_device() { throw_no_cuda(); }
int device_of(const void*, const char*) { throw_no_cuda(); }
DeviceScope::DeviceScope(int) : device_(0), outer_(0) { throw_no_cuda(); }
DeviceScope::~DeviceScope() = default;

}  // namespace treelet::cuda
