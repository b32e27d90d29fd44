#pragma once

#include <mutex>
#include <vector>

#include <treelet/core/stream.h>

struct CUevent_st;

namespace treelet::cuda {

/// Remembers which streams have used some memory, so that others can wait for them and the memory
/// is freed behind them all; a stream may be gone by then. Streams that are being captured are left
/// out: who replays a graph orders it.
class UseLog {
 public:
  UseLog() = default;
  ~UseLog();
  UseLog(const UseLog&) = delete;
  UseLog& operator=(const UseLog&) = delete;

  /// What has been enqueued on the stream so far is a use.
  void record(Stream stream);
  /// What is enqueued on the stream from now on comes after all uses on other streams.
  void order_behind(Stream stream) const;

 private:
  struct Use {
    Stream stream;
    CUevent_st* event;
  };
  mutable std::mutex mutex_;  // queries of many threads record here
  std::vector<Use> uses_;
};

/// A stream of treelet's own on the current device, which lives as long as the process: memory that
/// outlives the caller's streams is freed on it.
Stream own_stream();

}  // namespace treelet::cuda
