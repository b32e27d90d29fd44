#include <treelet/core/cuda_device.h>

namespace treelet::cuda {

bool is_compiled_in() { return false; }
bool is_available() { return false; }

std::string why_unavailable() {
  return "treelet was built without CUDA: build or install it with TREELET_CUDA=ON";
}

std::vector<DeviceInfo> devices() { return {}; }

}  // namespace treelet::cuda
