#include <treelet/core/stage.h>

#include <new>

namespace treelet {
namespace {

thread_local StageRecorder* listener = nullptr;

}  // namespace

StageRecorder::StageRecorder() : outer_(listener) { listener = this; }
StageRecorder::~StageRecorder() { listener = outer_; }

Stage::~Stage() {
  if (listener == nullptr) return;
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start_;
  try {
    listener->stages_.push_back({name_, elapsed.count()});
  } catch (const std::bad_alloc&) {
    // A time is lost; a destructor must not throw.
  }
}

}  // namespace treelet
