#include "emulator/engine.h"
#include "block_state.h"
#include "emulator/indices.h"

// Runs the threads of a block: who runs, who waits, who goes on.

thread_local constinit uint3 threadIdx{};
thread_local constinit uint3 blockIdx{};
thread_local constinit dim3 blockDim{};
thread_local constinit dim3 gridDim{};

namespace treelet::emulator {

thread_local constinit BlockState* current_block = nullptr;

namespace {

constexpr unsigned kTurnsBetweenPreemptions = 16;  // without a seed

std::uint32_t bit(unsigned lane) { return 1u << lane; }
unsigned lowest(std::uint32_t bits) { return unsigned(__builtin_ctz(bits)); }

/// The first set bit from `start` on, cyclically.
unsigned first_from(std::uint32_t bits, unsigned start) {
  const std::uint32_t later = bits & ~std::uint32_t(0) << start;
  return lowest(later != 0 ? later : bits);
}

/// In turns: the later lanes of the warp, its earlier lanes, then the next warp.
unsigned pick_in_turns(const BlockState& block) {
  unsigned warp = block.current / kWarpLanes;
  unsigned start = (block.current + 1) % kWarpLanes;
  if (block.warps[warp].ready == 0) {
    warp = first_from(block.ready_warps, (warp + 1) % kMaxWarps);
    start = 0;
  }
  return warp * kWarpLanes + first_from(block.warps[warp].ready, start);
}

/// Mostly of the same warp, so that also one that runs far ahead of the others is tried.
unsigned pick_at_random(BlockState& block) {
  const std::uint32_t random = block.random.next();
  unsigned warp = block.current / kWarpLanes;
  if (block.warps[warp].ready == 0 || random % 4 == 0) {
    warp = first_from(block.ready_warps, random >> 8 & 31);
  }
  return warp * kWarpLanes + first_from(block.warps[warp].ready, random >> 16 & 31);
}

unsigned pick_thread(BlockState& block) {
  return block.launch->seed == 0 ? pick_in_turns(block) : pick_at_random(block);
}

void go_on_with(BlockState& block, unsigned next) {
  if (next == block.current) return;
  Context& from = block.threads[block.current];
  block.current = next;
  threadIdx = block.thread_indices[next];
  switch_context(from, block.threads[next]);
}

void complete_barrier(BlockState& block) {
  BarrierState& barrier = block.barrier;
  switch (barrier.operation) {
    case Operation::kSyncBlockCount:
      barrier.result = barrier.count;
      break;
    case Operation::kSyncBlockAnd:
      barrier.result = barrier.all;
      break;
    case Operation::kSyncBlockOr:
      barrier.result = barrier.any;
      break;
    default:
      barrier.result = 0;
  }
  barrier.arrived = 0;
  ++barrier.generation;
  for (unsigned warp = 0; warp < block.warp_count; ++warp) {
    if (block.warps[warp].at_barrier != 0) make_ready(block, warp, block.warps[warp].at_barrier);
    block.warps[warp].at_barrier = 0;
  }
}

void fail_if_awaited(const BlockState& block, const WarpState& warp, unsigned lane) {
  for (std::uint32_t rest = warp.arrived; rest != 0; rest &= rest - 1) {
    if ((warp.contributions[lowest(rest)].mask & bit(lane)) == 0) continue;
    fail_in_block(block, "a lane exits that another lane waits for in a collective operation");
  }
}

void exit_thread(BlockState& block) {
  WarpState& warp = block.warps[block.current / kWarpLanes];
  const unsigned lane = block.current % kWarpLanes;
  fail_if_awaited(block, warp, lane);
  release_order(&block.end_place);
  set_unready(block);
  warp.exited |= bit(lane);
  --block.live;
  if (block.live == 0) {
    switch_context(block.threads[block.current], block.worker);
    return;
  }
  if (block.barrier.arrived == block.live) complete_barrier(block);
  wait_until_ready(block);
}

/// What the stack of a thread runs: one thread after the other, each of another block.
void run_threads() {
  enter_context();
  for (;;) {
    BlockState& block = *current_block;
    acquire_order(&block.begin_place);
    block.launch->run_thread(block.launch->context);
    exit_thread(block);
  }
}

void index_threads(BlockState& block, dim3 shape) {
  if (block.indexed_block.x == shape.x && block.indexed_block.y == shape.y &&
      block.indexed_block.z == shape.z) {
    return;
  }
  block.indexed_block = shape;
  unsigned i = 0;
  for (unsigned z = 0; z < shape.z; ++z) {
    for (unsigned y = 0; y < shape.y; ++y) {
      for (unsigned x = 0; x < shape.x; ++x) block.thread_indices[i++] = {x, y, z};
    }
  }
}

void reset_block(BlockState& block, const LaunchRecord& launch, std::uint64_t block_index) {
  block.launch = &launch;
  block.thread_count = block.live = launch.thread_count();
  block.warp_count = (block.thread_count + kWarpLanes - 1) / kWarpLanes;
  block.ready_warps = block.warp_count == kMaxWarps ? ~0u : bit(block.warp_count) - 1;
  block.turns = 0;
  block.random.state =
      launch.seed * 0xd1342543de82ef95u + launch.number * 0x9e3779b9u + block_index;
  block.barrier.arrived = 0;
  for (unsigned i = 0; i < block.warp_count; ++i) {
    WarpState& warp = block.warps[i];
    const unsigned lanes = block.thread_count - i * kWarpLanes;
    warp.ready = lanes >= kWarpLanes ? ~0u : bit(lanes) - 1;
    warp.exited = ~warp.ready;
    warp.arrived = warp.at_barrier = 0;
  }
  index_threads(block, launch.block);
}

uint3 to_index(std::uint64_t i, dim3 shape) {
  return {unsigned(i % shape.x), unsigned(i / shape.x % shape.y), unsigned(i / shape.x / shape.y)};
}

}  // namespace

void make_thread_context(Context& context, void* stack_bottom, std::size_t stack_bytes) {
  make_context(context, stack_bottom, stack_bytes, run_threads);
}

void set_unready(BlockState& block) {
  WarpState& warp = block.warps[block.current / kWarpLanes];
  warp.ready &= ~bit(block.current % kWarpLanes);
  if (warp.ready == 0) block.ready_warps &= ~bit(block.current / kWarpLanes);
}

void make_ready(BlockState& block, unsigned warp, std::uint32_t lanes) {
  block.warps[warp].ready |= lanes;
  block.ready_warps |= bit(warp);
}

void wait_until_ready(BlockState& block) {
  if (block.ready_warps == 0) {
    fail_in_block(block, "deadlock: all threads of a block wait, and none can go on");
  }
  go_on_with(block, pick_thread(block));
}

void maybe_preempt(BlockState& block) {
  if (block.launch->seed == 0 || block.random.next() % 4 != 0) return;
  go_on_with(block, pick_thread(block));
}

void run_block(BlockState& block, const LaunchRecord& launch, std::uint64_t block_index) {
  reset_block(block, launch, block_index);
  blockIdx = to_index(block_index, launch.grid);
  blockDim = launch.block;
  gridDim = launch.grid;
  current_block = &block;
  adopt_thread(block.worker);
  release_order(&block.begin_place);
  block.current = block.thread_count - 1;  // in turns, the next is thread 0
  block.current = pick_thread(block);
  threadIdx = block.thread_indices[block.current];
  switch_context(block.worker, block.threads[block.current]);
  acquire_order(&block.end_place);
  current_block = nullptr;
}

int meet_block(Operation operation, int value) {
  if (current_block == nullptr) fail("a barrier outside a kernel");
  BlockState& block = *current_block;
  BarrierState& barrier = block.barrier;
  if (barrier.arrived == 0) {
    barrier.operation = operation;
    barrier.count = barrier.any = 0;
    barrier.all = 1;
  } else if (barrier.operation != operation) {
    fail_in_block(block, "threads of a block meet in different kinds of __syncthreads");
  }
  barrier.count += value != 0;
  barrier.any |= value != 0;
  barrier.all &= value != 0;
  ++barrier.arrived;
  char* place = &barrier.order_places[barrier.generation % 2];
  release_order(place);
  block.warps[block.current / kWarpLanes].at_barrier |= bit(block.current % kWarpLanes);
  set_unready(block);
  if (barrier.arrived == block.live) complete_barrier(block);
  wait_until_ready(block);
  acquire_order(place);
  return barrier.result;
}

void preempt() {
  if (current_block == nullptr) return;
  BlockState& block = *current_block;
  if (block.launch->seed != 0) return maybe_preempt(block);
  if (++block.turns % kTurnsBetweenPreemptions == 0) go_on_with(block, pick_thread(block));
}

void yield_thread() {
  if (current_block != nullptr) go_on_with(*current_block, pick_thread(*current_block));
}

std::uint32_t own_lane_bit() {
  return current_block == nullptr ? 1u : bit(current_block->current % kWarpLanes);
}

}  // namespace treelet::emulator
