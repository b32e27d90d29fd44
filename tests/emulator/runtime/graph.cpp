#include <set>

#include "api.h"
#include "emulator/graphs.h"
#include "stream.h"

struct CUgraph_st {
  treelet::emulator::Nodes nodes;
};

struct CUgraphExec_st {
  std::shared_ptr<const treelet::emulator::Nodes> nodes;  // launches in a queue share it
};

using namespace treelet::emulator;

namespace {

template <class T>
std::set<T*>& made() {
  static auto* handles = new std::set<T*>;
  return *handles;
}

template <class T>
T* make(T value) {
  return *made<T>().insert(new T(std::move(value))).first;
}

template <class T>
cudaError_t destroy(T* handle) {
  if (made<T>().erase(handle) == 0) return cudaErrorInvalidValue;
  delete handle;
  return cudaSuccess;
}

}  // namespace

cudaError_t cudaStreamBeginCapture(cudaStream_t handle, cudaStreamCaptureMode mode) {
  return api_call([=] {
    CUstream_st* stream = find_stream(handle);
    if (stream == nullptr) return cudaErrorInvalidResourceHandle;
    if (stream == find_stream(nullptr)) return cudaErrorStreamCaptureUnsupported;
    if (stream->capture) return cudaErrorIllegalState;
    stream->capture = std::make_shared<Capture>();
    stream->capture->origin = stream;
    stream->capture->mode = mode;
    return cudaSuccess;
  });
}

cudaError_t cudaStreamEndCapture(cudaStream_t handle, cudaGraph_t* graph) {
  return api_call([=] {
    *graph = nullptr;
    CUstream_st* stream = find_stream(handle);
    if (stream == nullptr) return cudaErrorInvalidResourceHandle;
    if (!stream->capture) return cudaErrorIllegalState;
    const std::shared_ptr<Capture> capture = stream->capture;
    if (capture->origin != stream) return cudaErrorStreamCaptureUnmatched;
    end_capture(*capture);
    if (capture->is_invalid) return cudaErrorStreamCaptureInvalidated;
    *graph = make(CUgraph_st{std::move(capture->nodes)});
    return cudaSuccess;
  });
}

cudaError_t cudaStreamIsCapturing(cudaStream_t handle, cudaStreamCaptureStatus* status) {
  return api_call([=] {
    const CUstream_st* stream = find_stream(handle);
    if (stream == nullptr) return cudaErrorInvalidResourceHandle;
    *status = !stream->capture              ? cudaStreamCaptureStatusNone
              : stream->capture->is_invalid ? cudaStreamCaptureStatusInvalidated
                                            : cudaStreamCaptureStatusActive;
    return cudaSuccess;
  });
}

cudaError_t cudaGraphInstantiate(cudaGraphExec_t* executable, cudaGraph_t graph,
                                 unsigned long long) {
  return api_call([=] {
    if (!made<CUgraph_st>().contains(graph)) return cudaErrorInvalidValue;
    *executable = make(CUgraphExec_st{std::make_shared<const Nodes>(graph->nodes)});
    return cudaSuccess;
  });
}

cudaError_t cudaGraphLaunch(cudaGraphExec_t executable, cudaStream_t stream) {
  return api_call([=] {
    if (!made<CUgraphExec_st>().contains(executable)) return cudaErrorInvalidValue;
    return enqueue_work(stream, [nodes = executable->nodes] {
      for (const Work& node : *nodes) node();
    });
  });
}

cudaError_t cudaGraphExecDestroy(cudaGraphExec_t executable) {
  return api_call([=] { return destroy(executable); });
}

cudaError_t cudaGraphDestroy(cudaGraph_t graph) {
  return api_call([=] { return destroy(graph); });
}
