#include <treelet/core/device_stages.h>

#include <treelet/core/cuda_check.cuh>

namespace treelet::cuda {

DeviceStages::~DeviceStages() {
  for (const Mark& mark : marks_) cudaEventDestroy(mark.event);
  cudaGetLastError();
}

void DeviceStages::begin(const char* name) {
  cudaEvent_t event = nullptr;
  check(cudaEventCreate(&event), "create an event");
  marks_.push_back({name, event});
  check(cudaEventRecord(event, stream_), "record an event");
}

std::vector<StageTime> DeviceStages::finish() const {
  check(cudaEventSynchronize(marks_.back().event), "wait for an event");
  std::vector<StageTime> stages;
  for (std::size_t i = 0; i + 1 < marks_.size(); ++i) {
    float milliseconds = 0.0f;
    check(cudaEventElapsedTime(&milliseconds, marks_[i].event, marks_[i + 1].event),
          "read the time between events");
    stages.push_back({marks_[i].name, milliseconds * 1e-3});
  }
  return stages;
}

}  // namespace treelet::cuda
