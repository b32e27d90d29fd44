#pragma once

#include <treelet/core/parallel.h>

namespace treelet::test {

/// Runs loops on `count` threads while it lives.
class ThreadCountScope {
 public:
  explicit ThreadCountScope(unsigned count) : before_(thread_count()) { set_thread_count(count); }
  ~ThreadCountScope() { set_thread_count(before_); }
  ThreadCountScope(const ThreadCountScope&) = delete;
  ThreadCountScope& operator=(const ThreadCountScope&) = delete;

 private:
  unsigned before_;
};

}  // namespace treelet::test
