#include "context.h"
#include "emulator/engine.h"

#if !defined(TREELET_EMULATOR_TSAN)
#include <atomic>
#endif

namespace treelet::emulator {

void fence() {
  preempt();
#if defined(TREELET_EMULATOR_TSAN)
  // ThreadSanitizer knows no fences. What came before one fence comes before what follows any later
  // one: more than CUDA promises, which also wants an atomic between the two.
  static char all_fences;
  acquire_order(&all_fences);
  release_order(&all_fences);
#else
  std::atomic_thread_fence(std::memory_order_seq_cst);
#endif
}

}  // namespace treelet::emulator
