#include <treelet/core/parallel.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>

#if defined(__unix__) || defined(__APPLE__)
#include <pthread.h>
#endif

namespace treelet {
namespace {

/// One parallel loop in progress. It lives on the stack of the thread that called run_chunks.
struct Job {
  detail::ChunkFunction function;
  void* context;
  std::size_t chunk_count;
  std::atomic<std::size_t> next_chunk{0};
  std::size_t helpers = 0;  // guarded by the pool's mutex
  std::exception_ptr error{};
  std::mutex error_mutex{};

  bool has_chunks() const { return next_chunk.load(std::memory_order_relaxed) < chunk_count; }

  void work() {
    for (;;) {
      const std::size_t chunk = next_chunk.fetch_add(1, std::memory_order_relaxed);
      if (chunk >= chunk_count) return;
      try {
        function(context, chunk);
      } catch (...) {
        const std::lock_guard lock(error_mutex);
        if (!error) error = std::current_exception();
        next_chunk.store(chunk_count, std::memory_order_relaxed);
      }
    }
  }
};

class ThreadPool;

/// The pool whose loop this thread is in, so that a nested loop stays in it.
thread_local ThreadPool* surrounding_pool = nullptr;

/// Workers that help whichever job still has chunks; the caller always works on its own job, so
/// nested and concurrent loops finish even when every worker is busy elsewhere.
class ThreadPool {
 public:
  /// Has fewer threads where the system gives no more.
  explicit ThreadPool(unsigned threads) : threads_(threads) {
    try {
      for (unsigned i = 1; i < threads; ++i) {
        workers_.emplace_back([this] { help_until_stopped(); });
      }
    } catch (const std::exception&) {
    }
  }
  ~ThreadPool() {
    {
      const std::lock_guard lock(mutex_);
      stop_ = true;
    }
    wake_workers_.notify_all();
    for (std::thread& worker : workers_) worker.join();
  }
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  unsigned threads() const { return threads_; }

  void run(Job& job) {
    {
      const std::lock_guard lock(mutex_);
      jobs_.push_back(&job);
    }
    wake_workers_.notify_all();
    job.work();
    std::unique_lock lock(mutex_);
    jobs_.erase(std::find(jobs_.begin(), jobs_.end(), &job));
    wake_callers_.wait(lock, [&] { return job.helpers == 0; });
  }

 private:
  void help_until_stopped() {
    surrounding_pool = this;
    std::unique_lock lock(mutex_);
    for (;;) {
      Job* job = nullptr;
      wake_workers_.wait(lock, [&] { return stop_ || (job = find_job()) != nullptr; });
      if (stop_) return;
      ++job->helpers;
      lock.unlock();
      job->work();
      lock.lock();
      if (--job->helpers == 0) wake_callers_.notify_all();
    }
  }

  Job* find_job() const {
    for (Job* job : jobs_) {
      if (job->has_chunks()) return job;
    }
    return nullptr;
  }

  const unsigned threads_;
  std::mutex mutex_;
  std::condition_variable wake_workers_, wake_callers_;
  std::vector<Job*> jobs_;
  std::vector<std::thread> workers_;
  bool stop_ = false;
};

unsigned hardware_threads() { return std::max(1u, std::thread::hardware_concurrency()); }

/// The pool in use. Never destroyed: workers may still wait in it when the process exits.
struct PoolSlot {
  std::mutex mutex;
  unsigned threads = hardware_threads();
  std::shared_ptr<ThreadPool> pool;
};

PoolSlot* slot = nullptr;

void forget_pool_after_fork() {
  // The child has the memory of the pool but none of its threads, and its mutexes may be locked.
  surrounding_pool = nullptr;
  if (slot == nullptr) return;
  const unsigned threads = slot->threads;
  slot = new PoolSlot;
  slot->threads = threads;
}

PoolSlot& pool_slot() {
  static std::once_flag once;
  std::call_once(once, [] {
    slot = new PoolSlot;
#if defined(__unix__) || defined(__APPLE__)
    pthread_atfork(nullptr, nullptr, forget_pool_after_fork);
#endif
  });
  return *slot;
}

std::shared_ptr<ThreadPool> acquire_pool() {
  PoolSlot& current = pool_slot();
  const std::lock_guard lock(current.mutex);
  if (!current.pool) current.pool = std::make_shared<ThreadPool>(current.threads);
  return current.pool;
}

/// Marks this thread as inside a loop of the pool.
class InsidePool {
 public:
  explicit InsidePool(ThreadPool& pool) { surrounding_pool = &pool; }
  ~InsidePool() { surrounding_pool = nullptr; }
  InsidePool(const InsidePool&) = delete;
  InsidePool& operator=(const InsidePool&) = delete;
};

}  // namespace

unsigned thread_count() {
  PoolSlot& current = pool_slot();
  const std::lock_guard lock(current.mutex);
  return current.threads;
}

void set_thread_count(unsigned count) {
  PoolSlot& current = pool_slot();
  std::shared_ptr<ThreadPool> old;  // destroyed after the lock: joining may take a while
  const std::lock_guard lock(current.mutex);
  current.threads = count == 0 ? hardware_threads() : count;
  if (current.pool && current.pool->threads() != current.threads) old = std::move(current.pool);
}

void detail::run_chunks(std::size_t chunk_count, ChunkFunction function, void* context) {
  if (chunk_count == 1) return function(context, 0);
  Job job{function, context, chunk_count};
  if (surrounding_pool != nullptr) {
    surrounding_pool->run(job);
  } else {
    const std::shared_ptr<ThreadPool> pool = acquire_pool();
    const InsidePool inside(*pool);
    pool->run(job);
  }
  if (job.error) std::rethrow_exception(job.error);
}

}  // namespace treelet
