#pragma once

#include <vector>

#include <treelet/core/stage.h>
#include <treelet/core/stream.h>

struct CUevent_st;

namespace treelet::cuda {

/// Times stages of work on a stream by events between them: what Stage is for host code. Not for
/// streams that are being captured.
class DeviceStages {
 public:
  explicit DeviceStages(Stream stream) : stream_(stream) {}
  ~DeviceStages();
  DeviceStages(const DeviceStages&) = delete;
  DeviceStages& operator=(const DeviceStages&) = delete;

  /// Begins a stage where the one before ends. The name is a string literal.
  void begin(const char* name);
  /// Ends the last stage.
  void end() { begin(nullptr); }
  /// Waits for the end.
  std::vector<StageTime> finish() const;

 private:
  struct Mark {
    const char* name;
    CUevent_st* event;
  };
  Stream stream_;
  std::vector<Mark> marks_;
};

}  // namespace treelet::cuda
