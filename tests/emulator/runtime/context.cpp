#include "context.h"

#include "stack_switch.h"

#if defined(__SANITIZE_ADDRESS__)
#include <sanitizer/common_interface_defs.h>
#endif
#if defined(TREELET_EMULATOR_TSAN)
#include <sanitizer/tsan_interface.h>
#endif

namespace treelet::emulator {

#if defined(__SANITIZE_ADDRESS__)
namespace {
thread_local Context* left = nullptr;  // switched from last
thread_local Context* running = nullptr;
}  // namespace
#endif

void make_context(Context& context, void* stack_bottom, std::size_t stack_bytes, void (*entry)()) {
  context.stack_bottom = stack_bottom;
  context.stack_bytes = stack_bytes;
  context.stack_pointer = prepare_stack(stack_bottom, stack_bytes, entry);
#if defined(TREELET_EMULATOR_TSAN)
  context.tsan_fiber = __tsan_create_fiber(0);
#endif
}

void destroy_context([[maybe_unused]] Context& context) {
#if defined(TREELET_EMULATOR_TSAN)
  __tsan_destroy_fiber(context.tsan_fiber);
#endif
}

void adopt_thread([[maybe_unused]] Context& context) {
#if defined(TREELET_EMULATOR_TSAN)
  context.tsan_fiber = __tsan_get_current_fiber();
#endif
}

void enter_context() {
#if defined(__SANITIZE_ADDRESS__)
  __sanitizer_finish_switch_fiber(running->asan_fake_stack, &left->stack_bottom,
                                  &left->stack_bytes);
#endif
}

void switch_context(Context& from, Context& to) {
#if defined(TREELET_EMULATOR_TSAN)
  __tsan_switch_to_fiber(to.tsan_fiber, __tsan_switch_to_fiber_no_sync);
#endif
#if defined(__SANITIZE_ADDRESS__)
  left = &from;
  running = &to;
  __sanitizer_start_switch_fiber(&from.asan_fake_stack, to.stack_bottom, to.stack_bytes);
#endif
  switch_stack(&from.stack_pointer, to.stack_pointer);
  enter_context();
}

void release_order([[maybe_unused]] void* place) {
#if defined(TREELET_EMULATOR_TSAN)
  __tsan_release(place);
#endif
}

void acquire_order([[maybe_unused]] void* place) {
#if defined(TREELET_EMULATOR_TSAN)
  __tsan_acquire(place);
#endif
}

}  // namespace treelet::emulator
