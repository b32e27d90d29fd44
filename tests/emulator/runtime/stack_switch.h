#pragma once

#include <cstddef>

namespace treelet::emulator {

/// Lays out a stack so that a first switch to it calls entry(); returns its stack pointer.
void* prepare_stack(void* stack_bottom, std::size_t stack_bytes, void (*entry)());

/// Saves the registers that a call must preserve on the running stack, its stack pointer in *from,
/// and restores those of the stack `to`.
void switch_stack(void** from, void* to);

}  // namespace treelet::emulator
