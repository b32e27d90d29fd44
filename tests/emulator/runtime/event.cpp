#include <set>

#include "api.h"
#include "emulator/runtime_api.h"
#include "stream.h"

using namespace treelet::emulator;

namespace {

std::set<CUevent_st*>& events() {
  static auto* made = new std::set<CUevent_st*>;
  return *made;
}

bool exists(cudaEvent_t event) { return events().contains(event); }

void run_until_done(EventRecord& record) {
  if (!record.is_done) drain(*record.stream);
}

/// Lets a stream join the capture that the event was recorded in.
cudaError_t join_capture(CUstream_st& stream, const EventRecord& record) {
  if (stream.capture && stream.capture != record.capture) return cudaErrorInvalidValue;
  stream.capture = record.capture;
  return cudaSuccess;
}

}  // namespace

cudaError_t cudaEventCreate(cudaEvent_t* event) {
  return cudaEventCreateWithFlags(event, cudaEventDefault);
}

cudaError_t cudaEventCreateWithFlags(cudaEvent_t* event, unsigned flags) {
  return api_call([=] {
    *event = new CUevent_st{(flags & cudaEventDisableTiming) == 0, nullptr};
    events().insert(*event);
    return cudaSuccess;
  });
}

cudaError_t cudaEventDestroy(cudaEvent_t event) {
  return api_call([=] {
    if (events().erase(event) == 0) return cudaErrorInvalidResourceHandle;
    delete event;
    return cudaSuccess;
  });
}

cudaError_t cudaEventRecord(cudaEvent_t event, cudaStream_t handle) {
  return api_call([=] {
    CUstream_st* stream = find_stream(handle);
    if (!exists(event) || stream == nullptr) return cudaErrorInvalidResourceHandle;
    event->record = std::make_shared<EventRecord>();
    event->record->stream = stream;
    event->record->capture = stream->capture;
    return enqueue_work(handle, [record = event->record] {
      record->is_done = true;
      record->time = std::chrono::steady_clock::now();
    });
  });
}

cudaError_t cudaStreamWaitEvent(cudaStream_t handle, cudaEvent_t event, unsigned) {
  return api_call([=] {
    CUstream_st* stream = find_stream(handle);
    if (!exists(event) || stream == nullptr) return cudaErrorInvalidResourceHandle;
    if (!event->record) return cudaSuccess;
    if (event->record->capture) return join_capture(*stream, *event->record);
    return enqueue_work(handle, [record = event->record] { run_until_done(*record); });
  });
}

cudaError_t cudaEventSynchronize(cudaEvent_t event) {
  return api_call([=] {
    if (!exists(event)) return cudaErrorInvalidResourceHandle;
    if (!event->record) return cudaSuccess;
    if (event->record->capture) return cudaErrorStreamCaptureUnsupported;
    run_until_done(*event->record);
    return cudaSuccess;
  });
}

cudaError_t cudaEventQuery(cudaEvent_t event) {
  return api_call([=] {
    if (!exists(event)) return cudaErrorInvalidResourceHandle;
    if (!event->record || event->record->is_done) return cudaSuccess;
    if (event->record->capture) return cudaErrorStreamCaptureUnsupported;
    run_until_done(*event->record);
    return cudaErrorNotReady;  // this once
  });
}

cudaError_t cudaEventElapsedTime(float* milliseconds, cudaEvent_t begin, cudaEvent_t end) {
  return api_call([=] {
    if (!exists(begin) || !exists(end)) return cudaErrorInvalidResourceHandle;
    if (!begin->has_timing || !end->has_timing || !begin->record || !end->record) {
      return cudaErrorInvalidResourceHandle;
    }
    if (!begin->record->is_done || !end->record->is_done) return cudaErrorNotReady;
    const std::chrono::duration<float, std::milli> elapsed =
        end->record->time - begin->record->time;
    *milliseconds = elapsed.count();
    return cudaSuccess;
  });
}
