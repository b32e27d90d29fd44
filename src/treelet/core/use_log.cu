#include <treelet/core/use_log.h>

#include <algorithm>
#include <mutex>

#include <treelet/core/device_scope.h>
#include <treelet/core/cuda_check.cuh>

namespace treelet::cuda {
namespace {

bool is_captured(Stream stream) {
  cudaStreamCaptureStatus status = cudaStreamCaptureStatusNone;
  check(cudaStreamIsCapturing(stream, &status), "ask whether a stream is being captured");
  return status != cudaStreamCaptureStatusNone;
}

}  // namespace

UseLog::~UseLog() {
  for (const Use& use : uses_) cudaEventDestroy(use.event);
  cudaGetLastError();
}

void UseLog::record(Stream stream) {
  if (is_captured(stream)) return;
  const std::lock_guard lock(mutex_);
  auto use = std::find_if(uses_.begin(), uses_.end(),
                          [&](const Use& known) { return known.stream == stream; });
  if (use == uses_.end()) {
    cudaEvent_t event = nullptr;
    check(cudaEventCreateWithFlags(&event, cudaEventDisableTiming), "create an event");
    use = uses_.insert(uses_.end(), {stream, event});
  }
  check(cudaEventRecord(use->event, stream), "record an event");
}

void UseLog::order_behind(Stream stream) const {
  if (is_captured(stream)) return;
  const std::lock_guard lock(mutex_);
  for (const Use& use : uses_) {
    if (use.stream != stream) check(cudaStreamWaitEvent(stream, use.event, 0), "wait for an event");
  }
}

Stream own_stream() {
  static std::mutex mutex;
  static std::vector<cudaStream_t>* const streams = new std::vector<cudaStream_t>;  // kept
  const auto device = std::size_t(current_device());
  const std::lock_guard lock(mutex);
  if (streams->size() <= device) streams->resize(device + 1, nullptr);
  cudaStream_t& stream = (*streams)[device];
  if (stream == nullptr) {
    check(cudaStreamCreateWithFlags(&stream, cudaStreamNonBlocking), "create a stream");
  }
  return stream;
}

}  // namespace treelet::cuda
