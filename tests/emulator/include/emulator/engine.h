#pragma once

#include <cstdint>

// What kernels call in the emulator; runtime/engine.cpp answers.

namespace treelet::emulator {

enum class Operation : std::uint8_t {
  kSyncWarp,
  kShuffle,
  kShuffleUp,
  kShuffleDown,
  kShuffleXor,
  kBallot,
  kAny,
  kAll,
  kMatchAny,
  kReduceAdd,
  kReduceMin,
  kReduceMax,
  kReduceAnd,
  kReduceOr,
  kReduceXor,
  kSyncBlock,
  kSyncBlockCount,
  kSyncBlockAnd,
  kSyncBlockOr,
};

enum class ValueType : std::uint8_t {
  kNone,
  kInt,
  kUnsigned,
  kLongLong,
  kUnsignedLongLong,
  kFloat,
  kDouble,
};

/// What a thread brings to a collective operation of its warp or block.
struct Contribution {
  Operation operation;
  ValueType type;
  std::uint32_t mask;
  std::uint32_t operand;  // of a shuffle: lane, distance or pattern
  std::uint32_t width;    // of a shuffle: lanes in a segment
  std::uint64_t value;
};

/// Waits for the other lanes of the mask; returns the bits that this lane gets.
std::uint64_t meet_warp(const Contribution& contribution);
/// Waits for all threads of the block that have not exited.
int meet_block(Operation operation, int value);

/// May let other threads of the block run first.
void preempt();
/// Lets other threads of the block run first.
void yield_thread();
/// Orders what the calling thread did before and does after.
void fence();

/// Bit of the calling thread in its warp.
std::uint32_t own_lane_bit();
/// Ends the process and says where and why.
[[noreturn]] void fail(const char* message);

}  // namespace treelet::emulator
