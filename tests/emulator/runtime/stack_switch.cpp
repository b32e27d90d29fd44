#include "stack_switch.h"

#include <cstdint>

// Registers that a callee must preserve: [SysV ABI for x86-64 s3.2.1], [AAPCS64 s6.1]. The control
// words for rounding stay as they are: kernels do not change them.

#if defined(__x86_64__)

asm(R"(
  .text
  .globl treelet_emulator_switch_stack
  .type treelet_emulator_switch_stack, @function
treelet_emulator_switch_stack:
  endbr64
  pushq %rbp
  pushq %rbx
  pushq %r12
  pushq %r13
  pushq %r14
  pushq %r15
  movq %rsp, (%rdi)
  movq %rsi, %rsp
  popq %r15
  popq %r14
  popq %r13
  popq %r12
  popq %rbx
  popq %rbp
  ret
  .size treelet_emulator_switch_stack, .-treelet_emulator_switch_stack
)");

#elif defined(__aarch64__)

asm(R"(
  .text
  .globl treelet_emulator_switch_stack
  .type treelet_emulator_switch_stack, %function
treelet_emulator_switch_stack:
  sub sp, sp, #160
  stp x19, x20, [sp, #0]
  stp x21, x22, [sp, #16]
  stp x23, x24, [sp, #32]
  stp x25, x26, [sp, #48]
  stp x27, x28, [sp, #64]
  stp x29, x30, [sp, #80]
  stp d8, d9, [sp, #96]
  stp d10, d11, [sp, #112]
  stp d12, d13, [sp, #128]
  stp d14, d15, [sp, #144]
  mov x2, sp
  str x2, [x0]
  mov sp, x1
  ldp x19, x20, [sp, #0]
  ldp x21, x22, [sp, #16]
  ldp x23, x24, [sp, #32]
  ldp x25, x26, [sp, #48]
  ldp x27, x28, [sp, #64]
  ldp x29, x30, [sp, #80]
  ldp d8, d9, [sp, #96]
  ldp d10, d11, [sp, #112]
  ldp d12, d13, [sp, #128]
  ldp d14, d15, [sp, #144]
  add sp, sp, #160
  ret
  .size treelet_emulator_switch_stack, .-treelet_emulator_switch_stack
)");

#else

#include <ucontext.h>

#endif

namespace treelet::emulator {

#if defined(__x86_64__) || defined(__aarch64__)

extern "C" void treelet_emulator_switch_stack(void** from, void* to);

void switch_stack(void** from, void* to) { treelet_emulator_switch_stack(from, to); }

void* prepare_stack(void* stack_bottom, std::size_t stack_bytes, void (*entry)()) {
#if defined(__x86_64__)
  constexpr std::size_t kWords = 8,
                        kReturn = 6;  // entry() finds its stack 8 off 16, as after a call
#else
  constexpr std::size_t kWords = 20, kReturn = 11;
#endif
  const auto top = (reinterpret_cast<std::uintptr_t>(stack_bottom) + stack_bytes) & ~15ull;
  auto* words = reinterpret_cast<std::uintptr_t*>(top) - kWords;
  for (std::size_t i = 0; i < kWords; ++i) words[i] = 0;
  words[kReturn] = reinterpret_cast<std::uintptr_t>(entry);
  return words;
}

#else

// A ucontext_t for each stack, kept below its top; the "stack pointer" is its address.

void switch_stack(void** from, void* to) {
  ucontext_t here;
  *from = &here;
  swapcontext(&here, static_cast<ucontext_t*>(to));
}

void* prepare_stack(void* stack_bottom, std::size_t stack_bytes, void (*entry)()) {
  auto* context = new ucontext_t;  // lives as long as the stack, which is never freed
  getcontext(context);
  context->uc_stack.ss_sp = stack_bottom;
  context->uc_stack.ss_size = stack_bytes;
  context->uc_link = nullptr;
  makecontext(context, entry, 0);
  return context;
}

#endif

}  // namespace treelet::emulator
