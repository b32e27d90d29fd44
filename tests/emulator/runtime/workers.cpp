#include "workers.h"

#include <pthread.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <numeric>
#include <thread>
#include <vector>

#include "block_state.h"
#include "stacks.h"

// Threads of the host that run blocks, one at a time each.

namespace treelet::emulator {
namespace {

/// The order of a grid's blocks: as they are numbered, or by a random i -> (a i + b) mod n.
class BlockOrder {
 public:
  explicit BlockOrder(const LaunchRecord& launch) : count_(launch.block_count()) {
    if (launch.seed == 0) return;
    EngineRandom random{launch.seed + launch.number * 0x2545f491u};
    start_ = random.next() % count_;
    do {
      stride_ = random.next() % count_ + 1;
    } while (std::gcd(stride_, count_) != 1);
  }

  std::uint64_t count() const { return count_; }
  std::uint64_t at(std::uint64_t i) const { return (stride_ * i + start_) % count_; }

 private:
  std::uint64_t count_, start_ = 0, stride_ = 1;
};

class Workers {
 public:
  explicit Workers(unsigned count) {
    for (unsigned i = 0; i < count; ++i) threads_.emplace_back([this] { work(); });
  }
  ~Workers() {
    {
      const std::lock_guard lock(mutex_);
      stop_ = true;
    }
    wake_.notify_all();
    for (std::thread& thread : threads_) thread.join();
  }
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  std::size_t count() const { return threads_.size(); }

  void run(const LaunchRecord& launch) {
    const BlockOrder order(launch);
    std::unique_lock lock(mutex_);
    launch_ = &launch;
    order_ = &order;
    next_.store(0, std::memory_order_relaxed);
    busy_ = threads_.size();
    ++round_;
    wake_.notify_all();
    done_.wait(lock, [&] { return busy_ == 0; });
  }

 private:
  void work() {
    WorkerStacks stacks;
    std::unique_lock lock(mutex_);
    std::uint64_t seen = 0;
    for (;;) {
      wake_.wait(lock, [&] { return stop_ || round_ != seen; });
      if (stop_) return;
      seen = round_;
      lock.unlock();
      run_blocks(stacks);
      lock.lock();
      if (--busy_ == 0) done_.notify_all();
    }
  }

  void run_blocks(WorkerStacks& stacks) {
    for (;;) {
      const std::uint64_t i = next_.fetch_add(1, std::memory_order_relaxed);
      if (i >= order_->count()) return;
      run_block(stacks.block_for(launch_->thread_count()), *launch_, order_->at(i));
    }
  }

  std::mutex mutex_;
  std::condition_variable wake_, done_;
  const LaunchRecord* launch_ = nullptr;
  const BlockOrder* order_ = nullptr;
  std::atomic<std::uint64_t> next_{0};
  std::uint64_t round_ = 0;
  std::size_t busy_ = 0;
  bool stop_ = false;
  std::vector<std::thread> threads_;
};

/// Never destroyed: kernels may run until the process ends.
Workers* current_workers = nullptr;

/// A child process has the memory of the workers but not their threads.
void forget_workers() { current_workers = nullptr; }

}  // namespace

void run_grid(const LaunchRecord& launch, unsigned workers) {
  static std::once_flag once;
  std::call_once(once, [] { pthread_atfork(nullptr, nullptr, forget_workers); });
  const unsigned wanted = std::clamp(workers, 1u, max_workers());
  if (current_workers != nullptr && current_workers->count() != wanted) {
    delete current_workers;
    current_workers = nullptr;
  }
  if (current_workers == nullptr) current_workers = new Workers(wanted);
  current_workers->run(launch);
}

}  // namespace treelet::emulator
