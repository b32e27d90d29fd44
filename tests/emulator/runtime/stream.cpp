#include "stream.h"

#include <set>

#include "allocations.h"
#include "api.h"
#include "emulator/runtime_api.h"
#include "workers.h"

namespace treelet::emulator {
namespace {

/// Never destroyed: programs may free streams and memory while they end.
struct Streams {
  CUstream_st legacy;
  std::set<CUstream_st*> made;
};

Streams& streams() {
  static auto* all = new Streams;
  return *all;
}

std::uint64_t launches = 0;  // guarded by api_mutex()

/// The default stream and the blocking ones wait for each other.
void order_with_default_stream(CUstream_st& stream) {
  CUstream_st& legacy = streams().legacy;
  if (&stream != &legacy) {
    if (stream.is_blocking) drain(legacy);
    return;
  }
  for (CUstream_st* other : streams().made) {
    if (other->is_blocking) drain(*other);
  }
}

/// The default stream cannot wait for a stream that captures.
cudaError_t check_legacy_use(const CUstream_st& stream) {
  if (&stream != &streams().legacy) return cudaSuccess;
  for (CUstream_st* other : streams().made) {
    if (!other->is_blocking || !other->capture) continue;
    other->capture->is_invalid = true;
    return cudaErrorStreamCaptureImplicit;
  }
  return cudaSuccess;
}

}  // namespace

CUstream_st* find_stream(cudaStream_t handle) {
  if (handle == nullptr || handle == cudaStreamLegacy || handle == cudaStreamPerThread) {
    return &streams().legacy;
  }
  return streams().made.contains(handle) ? handle : nullptr;
}

cudaError_t enqueue_work(cudaStream_t handle, Work work) {
  CUstream_st* stream = find_stream(handle);
  if (stream == nullptr) return cudaErrorInvalidResourceHandle;
  if (stream->capture) {
    if (stream->capture->is_invalid) return cudaErrorStreamCaptureInvalidated;
    stream->capture->nodes.push_back(std::move(work));
    return cudaSuccess;
  }
  if (const cudaError_t error = check_legacy_use(*stream)) return error;
  order_with_default_stream(*stream);
  stream->queue.push_back(std::move(work));
  return cudaSuccess;
}

cudaError_t enqueue(cudaStream_t stream, std::function<void()> work) {
  return api_call([&] { return enqueue_work(stream, std::move(work)); });
}

void drain(CUstream_st& stream) {
  const DeviceMemoryAccess access;
  while (!stream.queue.empty()) {
    const Work work = std::move(stream.queue.front());
    stream.queue.pop_front();
    work();
  }
}

void drain_all() {
  drain(streams().legacy);
  for (CUstream_st* stream : streams().made) drain(*stream);
}

cudaError_t check_no_capture(cudaStreamCaptureMode strictest_allowed) {
  cudaError_t error = cudaSuccess;
  for (CUstream_st* stream : streams().made) {
    if (!stream->capture || stream->capture->mode >= strictest_allowed) continue;
    stream->capture->is_invalid = true;
    error = cudaErrorStreamCaptureUnsupported;
  }
  return error;
}

void end_capture(const Capture& capture) {
  for (CUstream_st* stream : streams().made) {
    if (stream->capture.get() == &capture) stream->capture = nullptr;
  }
}

/// A stream that records can be neither asked nor waited for: it spoils the recording.
cudaError_t check_not_captured(CUstream_st* stream) {
  if (stream == nullptr) return cudaErrorInvalidResourceHandle;
  if (!stream->capture) return cudaSuccess;
  stream->capture->is_invalid = true;
  return cudaErrorStreamCaptureUnsupported;
}

cudaError_t synchronize_device() {
  for (CUstream_st* stream : streams().made) {
    if (!stream->capture) continue;
    stream->capture->is_invalid = true;
    return cudaErrorStreamCaptureUnsupported;
  }
  drain_all();
  return cudaSuccess;
}

Work make_grid_work(const cudaLaunchConfig_t& config, const void* kernel, ThreadBody body) {
  return [grid = config.gridDim, block = config.blockDim, kernel, body = std::move(body)] {
    const Settings now = settings();
    LaunchRecord launch{kernel, grid, block, now.seed, ++launches, nullptr, &body};
    launch.run_thread = [](const void* context) { (*static_cast<const ThreadBody*>(context))(); };
    run_grid(launch, now.workers);
  };
}

std::uint64_t launch_count() {
  const std::lock_guard lock(api_mutex());
  return launches;
}

}  // namespace treelet::emulator

using namespace treelet::emulator;

cudaError_t cudaStreamCreate(cudaStream_t* stream) {
  return cudaStreamCreateWithFlags(stream, cudaStreamDefault);
}

cudaError_t cudaStreamCreateWithFlags(cudaStream_t* stream, unsigned flags) {
  return api_call([=] {
    auto* made = new CUstream_st;
    made->is_blocking = (flags & cudaStreamNonBlocking) == 0;
    streams().made.insert(made);
    *stream = made;
    return cudaSuccess;
  });
}

cudaError_t cudaStreamCreateWithPriority(cudaStream_t* stream, unsigned flags, int) {
  return cudaStreamCreateWithFlags(stream, flags);
}

cudaError_t cudaStreamDestroy(cudaStream_t handle) {
  return api_call([=] {
    if (!streams().made.contains(handle)) return cudaErrorInvalidResourceHandle;
    drain(*handle);
    if (handle->capture) handle->capture->is_invalid = true;
    streams().made.erase(handle);
    delete handle;
    return cudaSuccess;
  });
}

cudaError_t cudaStreamSynchronize(cudaStream_t handle) {
  return api_call([=] {
    CUstream_st* stream = find_stream(handle);
    if (const cudaError_t error = check_not_captured(stream)) return error;
    if (const cudaError_t error = check_legacy_use(*stream)) return error;
    order_with_default_stream(*stream);
    drain(*stream);
    return cudaSuccess;
  });
}

cudaError_t cudaStreamQuery(cudaStream_t handle) {
  return api_call([=] {
    CUstream_st* stream = find_stream(handle);
    if (const cudaError_t error = check_not_captured(stream)) return error;
    if (stream->queue.empty()) return cudaSuccess;
    drain(*stream);
    return cudaErrorNotReady;  // this once
  });
}

cudaError_t cudaLaunchHostFunc(cudaStream_t stream, void (*function)(void*), void* data) {
  return enqueue(stream, [=] { function(data); });
}
