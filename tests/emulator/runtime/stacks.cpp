#include "stacks.h"

#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <new>

#if defined(__SANITIZE_ADDRESS__)
#include <sanitizer/asan_interface.h>
#endif

namespace treelet::emulator {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr std::size_t kStackBytes = 256 << 10;  // their frames are larger
#else
constexpr std::size_t kStackBytes = 64 << 10;
#endif

std::size_t page_bytes() { return std::size_t(sysconf(_SC_PAGESIZE)); }

/// A stack below which lies a page that no one may touch.
void* allocate_stack() {
  const std::size_t guard = page_bytes();
  void* memory = mmap(nullptr, kStackBytes + guard, PROT_READ | PROT_WRITE,
                      MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (memory == MAP_FAILED) throw std::bad_alloc();
  mprotect(memory, guard, PROT_NONE);
  return static_cast<char*>(memory) + guard;
}

void free_stack(void* stack) {
#if defined(__SANITIZE_ADDRESS__)
  __asan_unpoison_memory_region(stack, kStackBytes);  // frames that will not return
#endif
  munmap(static_cast<char*>(stack) - page_bytes(), kStackBytes + page_bytes());
}

}  // namespace

unsigned max_workers() {
#if defined(__SANITIZE_THREAD__)
  return 7;  // each with a fiber for each of 1024 threads; ThreadSanitizer knows about 8000
#else
  return 64;
#endif
}

WorkerStacks::WorkerStacks() : block_(new BlockState()) {}

WorkerStacks::~WorkerStacks() {
  for (unsigned i = 0; i < block_->context_count; ++i) destroy_context(block_->threads[i]);
  for (void* stack : stacks_) free_stack(stack);
}

BlockState& WorkerStacks::block_for(unsigned threads) {
  for (; block_->context_count < threads; ++block_->context_count) {
    stacks_.push_back(allocate_stack());
    make_thread_context(block_->threads[block_->context_count], stacks_.back(), kStackBytes);
  }
  return *block_;
}

}  // namespace treelet::emulator
