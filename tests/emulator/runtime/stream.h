#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <vector>

#include "emulator/launch.h"
#include "emulator/runtime_types.h"

namespace treelet::emulator {

using Work = std::function<void()>;
using Nodes = std::vector<Work>;

/// What streams record instead of running it. The streams that joined hold it, too.
struct Capture {
  CUstream_st* origin = nullptr;
  cudaStreamCaptureMode mode = cudaStreamCaptureModeGlobal;
  bool is_invalid = false;
  Nodes nodes;
};

/// One call of cudaEventRecord.
struct EventRecord {
  CUstream_st* stream = nullptr;
  bool is_done = false;
  std::chrono::steady_clock::time_point time;
  std::shared_ptr<Capture> capture;
};

}  // namespace treelet::emulator

/// Work waits until someone waits for it: so a missing synchronisation shows.
struct CUstream_st {
  bool is_blocking = true;
  std::deque<treelet::emulator::Work> queue;
  std::shared_ptr<treelet::emulator::Capture> capture;
};

struct CUevent_st {
  bool has_timing = true;
  std::shared_ptr<treelet::emulator::EventRecord> record;
};

namespace treelet::emulator {

/// The stream of a handle, null where there is none.
CUstream_st* find_stream(cudaStream_t handle);

/// Appends to a stream, or to the graph that it captures.
cudaError_t enqueue_work(cudaStream_t handle, Work work);
/// Runs what a stream holds.
void drain(CUstream_st& stream);
/// Runs all streams.
void drain_all();

/// Whether a call that captures forbid may go on; if not, it ends them.
cudaError_t check_no_capture(cudaStreamCaptureMode strictest_allowed);
cudaError_t synchronize_device();
/// All its streams run what they are given again.
void end_capture(const Capture& capture);

Work make_grid_work(const cudaLaunchConfig_t& config, const void* kernel, ThreadBody body);

}  // namespace treelet::emulator
