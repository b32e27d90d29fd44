#include <treelet/core/parallel.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>

#include "support/random.h"
#include "support/threads.h"

namespace treelet {
namespace {

using test::Random;
using test::ThreadCountScope;

constexpr unsigned kThreadCounts[] = {1, 2, 3, 8};

/// Whether a loop over `count` indices calls each once.
bool covers_each_index_once(std::size_t count, std::size_t grain) {
  std::vector<std::atomic<int>> calls(count);
  parallel_for(count, grain, [&](std::size_t i) { calls.at(i).fetch_add(1); });
  return std::all_of(calls.begin(), calls.end(), [](const auto& call) { return call == 1; });
}

TEST(ParallelFor, CallsEachIndexOnce) {
  for (const unsigned threads : kThreadCounts) {
    const ThreadCountScope scope(threads);
    for (const std::size_t count : {0, 1, 2, 63, 64, 65, 1000, 20'000}) {
      for (const std::size_t grain : {1, 7, 64, 1 << 20}) {
        EXPECT_TRUE(covers_each_index_once(count, grain))
            << threads << " threads, " << count << " indices, grain " << grain;
      }
    }
  }
}

TEST(ParallelForRanges, DoNotDependOnThreads) {
  for (const unsigned threads : kThreadCounts) {
    const ThreadCountScope scope(threads);
    std::vector<std::size_t> end_of(1000, 0);
    parallel_for_ranges(1000, 64, [&](std::size_t begin, std::size_t end) { end_of[begin] = end; });
    for (std::size_t i = 0; i < 1000; ++i) {
      EXPECT_EQ(end_of[i], i % 64 == 0 ? std::min<std::size_t>(i + 64, 1000) : 0);
    }
  }
}

/// Lets threads wait until `expected` of them have come.
class Meeting {
 public:
  explicit Meeting(int expected) : missing_(expected) {}

  bool come() {
    std::unique_lock lock(mutex_);
    if (--missing_ == 0) all_here_.notify_all();
    return all_here_.wait_for(lock, std::chrono::seconds(20), [&] { return missing_ <= 0; });
  }

 private:
  std::mutex mutex_;
  std::condition_variable all_here_;
  int missing_;
};

TEST(ParallelFor, RunsOnAllThreadsAtTheSameTime) {
  for (const unsigned threads : kThreadCounts) {
    const ThreadCountScope scope(threads);
    Meeting meeting{int(threads)};
    std::atomic<int> met{0};
    parallel_for(threads, 1, [&](std::size_t) { met += meeting.come(); });
    EXPECT_EQ(met, int(threads));
  }
}

TEST(ParallelFor, RunsOnNoMoreThreadsThanAsked) {
  for (const unsigned threads : {1u, 2u, 3u}) {
    const ThreadCountScope scope(threads);
    std::atomic<unsigned> running{0};
    std::atomic<bool> too_many{false};
    parallel_for(8, 1, [&](std::size_t) {
      if (++running > threads) too_many = true;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      --running;
    });
    EXPECT_FALSE(too_many) << threads << " threads";
  }
}

TEST(ParallelFor, StaysOnTheCallerWithOneThread) {
  const ThreadCountScope scope(1);
  const std::thread::id caller = std::this_thread::get_id();
  parallel_for(100, 1, [&](std::size_t) { EXPECT_EQ(std::this_thread::get_id(), caller); });
}

TEST(ParallelFor, Nests) {
  for (const unsigned threads : kThreadCounts) {
    const ThreadCountScope scope(threads);
    std::vector<std::atomic<int>> calls(10 * 20 * 30);
    parallel_for(10, 1, [&](std::size_t i) {
      parallel_for(20, 3, [&](std::size_t j) {
        parallel_for(30, 7, [&](std::size_t k) { ++calls[(i * 20 + j) * 30 + k]; });
      });
    });
    for (const auto& call : calls) ASSERT_EQ(call, 1) << threads << " threads";
  }
}

TEST(ParallelFor, HasManyCallersAtATime) {
  for (const unsigned threads : kThreadCounts) {
    const ThreadCountScope scope(threads);
    std::atomic<int> good{0};
    std::vector<std::thread> callers;
    for (int caller = 0; caller < 6; ++caller) {
      callers.emplace_back([&] {
        for (int round = 0; round < 30; ++round) good += covers_each_index_once(500, 16);
      });
    }
    for (std::thread& caller : callers) caller.join();
    EXPECT_EQ(good, 6 * 30) << threads << " threads";
  }
}

TEST(ParallelFor, RethrowsAnExceptionAndGoesOnWorking) {
  for (const unsigned threads : kThreadCounts) {
    const ThreadCountScope scope(threads);
    for (const std::size_t bad : {0, 1, 500, 999}) {
      const auto throw_at_bad = [&](std::size_t i) {
        if (i == bad) throw std::runtime_error("index " + std::to_string(i));
      };
      try {
        parallel_for(1000, 1, throw_at_bad);
        ADD_FAILURE() << "nothing thrown";
      } catch (const std::runtime_error& error) {
        EXPECT_EQ(error.what(), "index " + std::to_string(bad));
      }
      EXPECT_TRUE(covers_each_index_once(1000, 10));
    }
  }
}

TEST(ParallelFor, RethrowsOneExceptionOfMany) {
  for (const unsigned threads : kThreadCounts) {
    const ThreadCountScope scope(threads);
    EXPECT_THROW(parallel_for(1000, 1, [](std::size_t i) { throw i; }), std::size_t);
    EXPECT_THROW(parallel_for(5, 10, [](std::size_t i) { throw i; }), std::size_t);
    EXPECT_TRUE(covers_each_index_once(1000, 10));
  }
}

TEST(ParallelFor, RethrowsThroughNestedLoops) {
  const ThreadCountScope scope(3);
  const auto inner = [](std::size_t i) {
    parallel_for(50, 1, [&](std::size_t j) {
      if (i == 7 && j == 31) throw std::out_of_range("inner");
    });
  };
  EXPECT_THROW(parallel_for(20, 1, inner), std::out_of_range);
  EXPECT_TRUE(covers_each_index_once(1000, 10));
}

TEST(SetThreadCount, IsWhatThreadCountSays) {
  const ThreadCountScope scope(5);
  EXPECT_EQ(thread_count(), 5u);
  set_thread_count(0);
  EXPECT_EQ(thread_count(), std::max(1u, std::thread::hardware_concurrency()));
}

TEST(SetThreadCount, MayChangeWhileLoopsRun) {
  const ThreadCountScope scope(2);
  constexpr int loops = 200;
  std::atomic<int> callers_running{3}, good{0};
  std::vector<std::thread> callers;
  for (int caller = 0; caller < 3; ++caller) {
    callers.emplace_back([&] {
      for (int loop = 0; loop < loops; ++loop) good += covers_each_index_once(300, 8);
      --callers_running;
    });
  }
  for (unsigned round = 0; callers_running > 0; ++round) set_thread_count(1 + round % 5);
  for (std::thread& caller : callers) caller.join();
  EXPECT_EQ(good, 3 * loops);
}

TEST(SetThreadCount, MayBeCalledFromALoop) {
  const ThreadCountScope scope(3);
  std::atomic<int> calls{0};
  parallel_for(100, 1, [&](std::size_t i) {
    set_thread_count(unsigned(1 + i % 4));
    parallel_for(10, 1, [&](std::size_t) { ++calls; });
  });
  EXPECT_EQ(calls, 1000);
}

TEST(ParallelReduce, OfNothingIsTheIdentity) {
  const auto never = [](std::size_t, std::size_t) { return 1; };
  EXPECT_EQ(parallel_reduce(0, 10, 42, never, [](int a, int b) { return a + b; }), 42);
}

TEST(ParallelReduce, CombinesInIndexOrder) {
  for (const unsigned threads : kThreadCounts) {
    const ThreadCountScope scope(threads);
    const auto name = [](std::size_t begin, std::size_t end) {
      return std::to_string(begin) + "-" + std::to_string(end) + " ";
    };
    const std::string joined = parallel_reduce(
        10, 3, std::string(), name, [](std::string a, const std::string& b) { return a + b; });
    EXPECT_EQ(joined, "0-3 3-6 6-9 9-10 ");
  }
}

TEST(ParallelReduce, SumsFloatsToTheSameBits) {
  constexpr std::uint64_t seed = 21;
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  std::vector<float> values(50'000);
  for (float& value : values) value = random.uniform(-1.0f, 1.0f);
  const auto sum_range = [&](std::size_t begin, std::size_t end) {
    float sum = 0.0f;
    for (std::size_t i = begin; i < end; ++i) sum += values[i];
    return sum;
  };
  float expected = 0.0f;
  for (std::size_t i = 0; i < values.size(); i += 100) expected += sum_range(i, i + 100);
  for (const unsigned threads : kThreadCounts) {
    const ThreadCountScope scope(threads);
    const float sum = parallel_reduce(values.size(), 100, 0.0f, sum_range,
                                      [](float a, float b) { return a + b; });
    EXPECT_EQ(std::bit_cast<std::uint32_t>(sum), std::bit_cast<std::uint32_t>(expected));
  }
}

// More than any system gives: loops run with what there is. Not under sanitizers, which keep books
// for each thread.
TEST(SlowParallel, AsksForMoreThreadsThanThereAre) {
  const test::ThreadCountScope scope(100000);
  std::atomic<int> sum = 0;
  parallel_for(1000, 10, [&](std::size_t i) { sum += int(i); });
  EXPECT_EQ(sum, 499500);
}

}  // namespace
}  // namespace treelet
