#pragma once

#include <cstddef>

// Cooperative switching between stacks, known to the sanitizers.

namespace treelet::emulator {

/// Where a stack of execution stands while another one runs.
struct Context {
  void* stack_pointer = nullptr;
  const void* stack_bottom = nullptr;
  std::size_t stack_bytes = 0;
  void* asan_fake_stack = nullptr;
  void* tsan_fiber = nullptr;
};

/// Prepares a context that calls entry() on the given stack; entry must not return.
void make_context(Context& context, void* stack_bottom, std::size_t stack_bytes, void (*entry)());
/// Before its stack is freed.
void destroy_context(Context& context);
/// Makes the stack that the calling thread is on a context that can be switched from.
void adopt_thread(Context& context);
/// The first thing that entry() does.
void enter_context();
/// Suspends `from`, which runs, and goes on with `to`.
void switch_context(Context& from, Context& to);

/// For ThreadSanitizer: what came before a release of a place comes before what follows an acquire
/// of it later. Nothing without it.
void release_order(void* place);
void acquire_order(void* place);

}  // namespace treelet::emulator
