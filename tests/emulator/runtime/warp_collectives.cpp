#include "block_state.h"
#include "emulator/engine.h"

// Collective operations of a warp: lanes wait until all of their mask have come, and the last one
// works out what each gets.

namespace treelet::emulator {
namespace {

std::uint32_t bit(unsigned lane) { return 1u << lane; }
unsigned lowest(std::uint32_t bits) { return unsigned(__builtin_ctz(bits)); }

/// The lane that a lane reads from; itself where the other one is outside its segment.
/// [PTX ISA, shfl.sync]
unsigned source_lane(const Contribution& c, unsigned lane) {
  const unsigned first = lane & ~(c.width - 1), last = lane | (c.width - 1);
  switch (c.operation) {
    case Operation::kShuffle:
      return first | (c.operand & (c.width - 1));
    case Operation::kShuffleUp:
      return c.operand <= lane - first ? lane - c.operand : lane;
    case Operation::kShuffleDown:
      return c.operand <= last - lane ? lane + c.operand : lane;
    default:
      return (lane ^ c.operand) <= last ? lane ^ c.operand : lane;
  }
}

void shuffle(const BlockState& block, WarpState& warp, std::uint32_t mask) {
  for (std::uint32_t rest = mask; rest != 0; rest &= rest - 1) {
    const unsigned lane = lowest(rest);
    const unsigned source = source_lane(warp.contributions[lane], lane);
    if ((mask & bit(source)) == 0) {
      fail_in_block(block, "a shuffle reads from a lane that is not in its mask");
    }
    warp.results[lane] = warp.contributions[source].value;
  }
}

void give_to_all(WarpState& warp, std::uint32_t mask, std::uint64_t result) {
  for (std::uint32_t rest = mask; rest != 0; rest &= rest - 1) warp.results[lowest(rest)] = result;
}

std::uint32_t ballot(const WarpState& warp, std::uint32_t mask) {
  std::uint32_t votes = 0;
  for (std::uint32_t rest = mask; rest != 0; rest &= rest - 1) {
    if (warp.contributions[lowest(rest)].value != 0) votes |= rest & -rest;
  }
  return votes;
}

void match_any(WarpState& warp, std::uint32_t mask) {
  for (std::uint32_t rest = mask; rest != 0;) {
    const std::uint64_t value = warp.contributions[lowest(rest)].value;
    std::uint32_t equal = 0;
    for (std::uint32_t others = rest; others != 0; others &= others - 1) {
      if (warp.contributions[lowest(others)].value == value) equal |= others & -others;
    }
    give_to_all(warp, equal, equal);
    rest &= ~equal;
  }
}

template <class T>
T combine(Operation operation, T a, T b) {
  switch (operation) {
    case Operation::kReduceAdd:
      return T(std::uint32_t(a) + std::uint32_t(b));
    case Operation::kReduceMin:
      return a < b ? a : b;
    case Operation::kReduceMax:
      return a > b ? a : b;
    case Operation::kReduceAnd:
      return a & b;
    case Operation::kReduceOr:
      return a | b;
    default:
      return a ^ b;
  }
}

template <class T>
std::uint64_t reduce(const WarpState& warp, std::uint32_t mask) {
  T total = T(warp.contributions[lowest(mask)].value);
  for (std::uint32_t rest = mask & (mask - 1); rest != 0; rest &= rest - 1) {
    const Contribution& c = warp.contributions[lowest(rest)];
    total = combine(c.operation, total, T(c.value));
  }
  return std::uint32_t(total);
}

void complete(const BlockState& block, WarpState& warp, const Contribution& c) {
  switch (c.operation) {
    case Operation::kSyncWarp:
      return;
    case Operation::kShuffle:
    case Operation::kShuffleUp:
    case Operation::kShuffleDown:
    case Operation::kShuffleXor:
      return shuffle(block, warp, c.mask);
    case Operation::kBallot:
      return give_to_all(warp, c.mask, ballot(warp, c.mask));
    case Operation::kAny:
      return give_to_all(warp, c.mask, ballot(warp, c.mask) != 0);
    case Operation::kAll:
      return give_to_all(warp, c.mask, ballot(warp, c.mask) == c.mask);
    case Operation::kMatchAny:
      return match_any(warp, c.mask);
    default:
      return give_to_all(warp, c.mask,
                         c.type == ValueType::kInt ? reduce<std::int32_t>(warp, c.mask)
                                                   : reduce<std::uint32_t>(warp, c.mask));
  }
}

/// Whether all lanes of the mask wait for this very operation. Fails where one never will: it
/// waits for this lane in another one.
bool all_agree(const BlockState& block, const WarpState& warp, const Contribution& c,
               unsigned lane) {
  for (std::uint32_t rest = c.mask; rest != 0; rest &= rest - 1) {
    const Contribution& other = warp.contributions[lowest(rest)];
    if (other.mask != c.mask) {
      if ((other.mask & bit(lane)) == 0) return false;
      fail_in_block(block, "lanes of a warp meet with different masks");
    }
    if (other.operation != c.operation || other.type != c.type || other.width != c.width) {
      fail_in_block(block, "lanes of a warp meet in different collective operations");
    }
  }
  return true;
}

void check_contribution(const BlockState& block, const WarpState& warp, const Contribution& c,
                        unsigned lane) {
  if ((c.mask & bit(lane)) == 0) fail_in_block(block, "a lane is not in its own mask");
  if ((c.mask & warp.exited) != 0) {
    fail_in_block(block, "a mask names a lane that has exited or that the block does not have");
  }
  if (c.width == 0 || c.width > kWarpLanes || (c.width & (c.width - 1)) != 0) {
    fail_in_block(block, "the width of a shuffle is not a power of two up to 32");
  }
}

/// The place through which the lanes of a __syncwarp order memory: that of the lanes which wait in
/// it already, else a new one.
unsigned choose_place(WarpState& warp, const Contribution& c) {
  for (std::uint32_t rest = warp.arrived & c.mask; rest != 0; rest &= rest - 1) {
    if (warp.contributions[lowest(rest)].mask == c.mask) return warp.places[lowest(rest)];
  }
  return warp.next_place++ % WarpState::kOrderPlaces;
}

}  // namespace

std::uint64_t meet_warp(const Contribution& c) {
  if (current_block == nullptr) fail("a collective operation outside a kernel");
  BlockState& block = *current_block;
  const unsigned warp_index = block.current / kWarpLanes, lane = block.current % kWarpLanes;
  WarpState& warp = block.warps[warp_index];
  check_contribution(block, warp, c, lane);
  char* place = nullptr;
  if (c.operation == Operation::kSyncWarp) {
    warp.places[lane] = choose_place(warp, c);
    release_order(place = &warp.order_places[warp.places[lane]]);
  }
  warp.contributions[lane] = c;
  warp.arrived |= bit(lane);
  if ((warp.arrived & c.mask) == c.mask && all_agree(block, warp, c, lane)) {
    complete(block, warp, c);
    warp.arrived &= ~c.mask;
    make_ready(block, warp_index, c.mask);
    maybe_preempt(block);
  } else {
    set_unready(block);
    wait_until_ready(block);
  }
  if (place != nullptr) acquire_order(place);
  return warp.results[lane];
}

}  // namespace treelet::emulator
