#pragma once

#include <cstdint>

#include "context.h"
#include "emulator/engine.h"
#include "emulator/vector_types.h"
#include "launch_record.h"

// Plain data only: the files that change it are compiled without ThreadSanitizer, which would
// report the engine's own reads and writes, and must not leave copies of shared inline functions.

namespace treelet::emulator {

constexpr unsigned kWarpLanes = 32;
constexpr unsigned kMaxThreads = 1024;
constexpr unsigned kMaxWarps = kMaxThreads / kWarpLanes;

/// Bits stand for lanes. A lane is ready, arrived at a collective operation of its warp, at a
/// barrier of its block, or has exited; lanes that the block does not fill count as exited.
struct WarpState {
  std::uint32_t ready;
  std::uint32_t arrived;
  std::uint32_t at_barrier;
  std::uint32_t exited;
  Contribution contributions[kWarpLanes];
  std::uint64_t results[kWarpLanes];

  // __syncwarp orders memory: its lanes share one of these places (context.h), each use the next.
  static constexpr unsigned kOrderPlaces = 64;
  char order_places[kOrderPlaces];
  unsigned next_place;
  unsigned places[kWarpLanes];
};

struct BarrierState {
  Operation operation;
  unsigned arrived;
  int count, all, any;  // of the predicates so far
  int result;           // of the last barrier
  unsigned generation;
  char order_places[2];  // used in turns
};

/// splitmix64 [Steele2014 fig. 16]
struct EngineRandom {
  std::uint64_t state;

  std::uint32_t next() {
    std::uint64_t z = state += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return std::uint32_t((z ^ z >> 31) >> 32);
  }
};

/// The block that a worker runs. Thread i is lane i % 32 of warp i / 32.
struct BlockState {
  const LaunchRecord* launch;
  unsigned thread_count;
  unsigned warp_count;
  unsigned live;     // threads that have not exited
  unsigned current;  // the thread that runs
  std::uint32_t ready_warps;
  unsigned turns;  // atomics and fences since the last pre-emption
  EngineRandom random;
  BarrierState barrier;
  WarpState warps[kMaxWarps];

  uint3 thread_indices[kMaxThreads];
  dim3 indexed_block;  // whose thread_indices these are
  char begin_place, end_place;

  Context worker;
  Context threads[kMaxThreads];
  unsigned context_count;  // threads that have a stack
};

/// The block that the calling thread of the host runs; null outside kernels.
extern thread_local constinit BlockState* current_block;

/// Prepares a context that runs threads of the current block, one block after the other.
void make_thread_context(Context& context, void* stack_bottom, std::size_t stack_bytes);
void run_block(BlockState& block, const LaunchRecord& launch, std::uint64_t block_index);

// Scheduling (engine.cpp).
void make_ready(BlockState& block, unsigned warp, std::uint32_t lanes);
/// The current thread is to wait.
void set_unready(BlockState& block);
/// With a seed, lets others run first at times.
void maybe_preempt(BlockState& block);
/// Lets others run until the current thread, which is not ready, is.
void wait_until_ready(BlockState& block);

/// Writes where the process stands, what all threads of the block wait for, and ends it.
[[noreturn]] void fail_in_block(const BlockState& block, const char* message);

}  // namespace treelet::emulator
