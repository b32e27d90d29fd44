#pragma once

#include <chrono>
#include <string>
#include <vector>

namespace treelet {

/// Wall-clock time of one named part of a build.
struct StageTime {
  std::string name;
  double seconds;
};

/// Collects the stages that end on this thread while it lives. Recorders may nest; the innermost
/// one listens.
class StageRecorder {
 public:
  StageRecorder();
  ~StageRecorder();
  StageRecorder(const StageRecorder&) = delete;
  StageRecorder& operator=(const StageRecorder&) = delete;

  const std::vector<StageTime>& stages() const { return stages_; }

 private:
  friend class Stage;
  std::vector<StageTime> stages_;
  StageRecorder* outer_;
};

/// `Stage stage{"sort morton codes"};` times its scope, where somebody listens.
class Stage {
 public:
  explicit Stage(const char* name) : name_(name), start_(std::chrono::steady_clock::now()) {}
  ~Stage();
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;

 private:
  const char* name_;
  std::chrono::steady_clock::time_point start_;
};

}  // namespace treelet
