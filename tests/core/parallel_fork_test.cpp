#include <gtest/gtest.h>
#include <treelet/core/parallel.h>

#if defined(__unix__) || defined(__APPLE__)

#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <numeric>
#include <thread>
#include <vector>

#include "support/threads.h"

// The thread sanitizer does not follow a process with threads through fork(), and the address
// sanitizer's allocator may be locked by another thread when a fork copies it.
#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__)
#define TREELET_CAN_FORK 0
#elif defined(__has_feature)
#define TREELET_CAN_FORK !__has_feature(thread_sanitizer) && !__has_feature(address_sanitizer)
#else
#define TREELET_CAN_FORK 1
#endif

#if TREELET_CAN_FORK

namespace treelet {
namespace {

constexpr int kGood = 17, kBad = 1;

bool can_run_loops() {
  std::vector<int> values(10'000, 0);
  parallel_for(values.size(), 16, [&](std::size_t i) { values[i] = 1; });
  return std::accumulate(values.begin(), values.end(), 0) == 10'000;
}

/// Exit code of a child that runs loops; -1 if it did not exit by itself. A child that hangs is
/// ended by its alarm.
int run_loops_in_child(unsigned expected_threads) {
  const pid_t child = fork();
  if (child == 0) {
    alarm(20);
    const bool good = thread_count() == expected_threads && can_run_loops() && can_run_loops();
    _exit(good ? kGood : kBad);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST(ParallelForAfterFork, WorksInTheChildAndInTheParent) {
  const test::ThreadCountScope scope(4);
  ASSERT_TRUE(can_run_loops());  // so that there are workers the child lacks
  EXPECT_EQ(run_loops_in_child(4), kGood);
  EXPECT_TRUE(can_run_loops());
  EXPECT_EQ(run_loops_in_child(4), kGood);
}

TEST(ParallelForAfterFork, WorksWhileAnotherThreadIsInALoop) {
  const test::ThreadCountScope scope(3);
  std::atomic<bool> stop{false};
  std::thread busy([&] {
    while (!stop) can_run_loops();
  });
  for (int round = 0; round < 10; ++round) EXPECT_EQ(run_loops_in_child(3), kGood);
  stop = true;
  busy.join();
}

}  // namespace
}  // namespace treelet

#endif
#endif
