#include <cstdio>
#include <cstdlib>

#include "block_state.h"
#include "emulator/indices.h"
#include "symbol_name.h"

// The message before the end. Compiled like the engine: see block_state.h.

namespace treelet::emulator {
namespace {

const char* name_of(Operation operation) {
  switch (operation) {
    case Operation::kSyncWarp:
      return "__syncwarp";
    case Operation::kShuffle:
      return "__shfl_sync";
    case Operation::kShuffleUp:
      return "__shfl_up_sync";
    case Operation::kShuffleDown:
      return "__shfl_down_sync";
    case Operation::kShuffleXor:
      return "__shfl_xor_sync";
    case Operation::kBallot:
      return "__ballot_sync";
    case Operation::kAny:
      return "__any_sync";
    case Operation::kAll:
      return "__all_sync";
    case Operation::kMatchAny:
      return "__match_any_sync";
    case Operation::kReduceAdd:
      return "__reduce_add_sync";
    case Operation::kReduceMin:
      return "__reduce_min_sync";
    case Operation::kReduceMax:
      return "__reduce_max_sync";
    case Operation::kReduceAnd:
      return "__reduce_and_sync";
    case Operation::kReduceOr:
      return "__reduce_or_sync";
    case Operation::kReduceXor:
      return "__reduce_xor_sync";
    case Operation::kSyncBlock:
      return "__syncthreads";
    case Operation::kSyncBlockCount:
      return "__syncthreads_count";
    case Operation::kSyncBlockAnd:
      return "__syncthreads_and";
    case Operation::kSyncBlockOr:
      return "__syncthreads_or";
  }
  return "?";
}

const char* name_of(ValueType type) {
  switch (type) {
    case ValueType::kNone:
      return "";
    case ValueType::kInt:
      return "<int>";
    case ValueType::kUnsigned:
      return "<unsigned>";
    case ValueType::kLongLong:
      return "<long long>";
    case ValueType::kUnsignedLongLong:
      return "<unsigned long long>";
    case ValueType::kFloat:
      return "<float>";
    case ValueType::kDouble:
      return "<double>";
  }
  return "?";
}

bool is_same_wait(const Contribution& a, const Contribution& b) {
  return a.operation == b.operation && a.type == b.type && a.mask == b.mask;
}

void print_lanes(unsigned warp, std::uint32_t lanes) {
  std::fprintf(stderr, "    warp %u, lane%s", warp, (lanes & (lanes - 1)) == 0 ? "" : "s");
  for (unsigned lane = 0; lane < kWarpLanes; ++lane) {
    if ((lanes >> lane & 1) == 0) continue;
    unsigned last = lane;
    while (last + 1 < kWarpLanes && (lanes >> (last + 1) & 1) != 0) ++last;
    std::fprintf(stderr, last == lane ? " %u" : " %u-%u", lane, last);
    lane = last;
  }
}

void print_arrived(unsigned index, const WarpState& warp) {
  for (std::uint32_t rest = warp.arrived; rest != 0;) {
    const Contribution& c = warp.contributions[__builtin_ctz(rest)];
    std::uint32_t same = 0;
    for (unsigned lane = 0; lane < kWarpLanes; ++lane) {
      if ((rest >> lane & 1) != 0 && is_same_wait(warp.contributions[lane], c)) same |= 1u << lane;
    }
    print_lanes(index, same);
    std::fprintf(stderr, ": in %s%s, mask 0x%08x\n", name_of(c.operation), name_of(c.type), c.mask);
    rest &= ~same;
  }
}

void print_warp(const BlockState& block, unsigned index) {
  const WarpState& warp = block.warps[index];
  print_arrived(index, warp);
  if (warp.at_barrier != 0) {
    print_lanes(index, warp.at_barrier);
    std::fprintf(stderr, ": in %s\n", name_of(block.barrier.operation));
  }
  if (warp.ready != 0) {
    print_lanes(index, warp.ready);
    std::fprintf(stderr, ": not waiting\n");
  }
  const unsigned lanes = block.thread_count - index * kWarpLanes;
  const std::uint32_t exists = lanes >= kWarpLanes ? ~0u : (1u << lanes) - 1;
  if ((warp.exited & exists) != 0) {
    print_lanes(index, warp.exited & exists);
    std::fprintf(stderr, ": exited\n");
  }
}

}  // namespace

void fail_in_block(const BlockState& block, const char* message) {
  char name[512];
  find_symbol_name(block.launch->kernel, name, sizeof name);
  const uint3 thread = block.thread_indices[block.current];
  std::fprintf(stderr, "\nCUDA emulator: %s\n", message);
  std::fprintf(stderr, "  kernel %s, launch %llu, seed %llu\n", name,
               static_cast<unsigned long long>(block.launch->number),
               static_cast<unsigned long long>(block.launch->seed));
  std::fprintf(stderr, "  block (%u, %u, %u), thread (%u, %u, %u): warp %u, lane %u\n", blockIdx.x,
               blockIdx.y, blockIdx.z, thread.x, thread.y, thread.z, block.current / kWarpLanes,
               block.current % kWarpLanes);
  std::fprintf(stderr, "  the threads of the block:\n");
  for (unsigned warp = 0; warp < block.warp_count; ++warp) print_warp(block, warp);
  std::fflush(stderr);
  std::abort();
}

void fail(const char* message) {
  if (current_block != nullptr) fail_in_block(*current_block, message);
  std::fprintf(stderr, "\nCUDA emulator: %s\n", message);
  std::fflush(stderr);
  std::abort();
}

}  // namespace treelet::emulator
