#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <utility>

#include <treelet/core/platform.h>
#include <treelet/optimize/subset_tables.h>

// Which lane of a warp tries which partition of which subset, and when [KarrasAila2013 s3.3]:
//
//     subsets of 2 to n - 2 leaves   a lane each, in rounds of one size and up to 32 subsets
//     subsets of n - 1 leaves        four lanes each: each has its choice of two of the leaves
//     the whole treelet              all lanes
//
// n = 7 takes 1 + 3 + 3 + 7 + 7 + 15 + 8 + 2 = 46 partitions in a row for 966. Differs: the paper
// fills idle lanes of a round with larger subsets, which saves a round and costs five partitions.

namespace treelet {

template <int Size>
struct TreeletSchedule {
  static constexpr int kLanes = 32;
  static constexpr std::uint32_t kWhole = (1u << Size) - 1;

  static constexpr int count_rounds() {
    int rounds = 0;
    for (int leaves = 2, sets = Size * (Size - 1) / 2; leaves <= Size - 2; ++leaves) {
      rounds += (sets + kLanes - 1) / kLanes;
      sets = sets * (Size - leaves) / (leaves + 1);  // binomial coefficients
    }
    return rounds;
  }
  static constexpr int kRounds = count_rounds();

  std::array<int, std::size_t(kRounds)> leaves{};  ///< of the sets of a round
  std::array<std::array<std::uint8_t, kLanes>, std::size_t(kRounds)> sets{};  ///< 0: idle
};

template <int Size>
constexpr TreeletSchedule<Size> make_treelet_schedule() {
  TreeletSchedule<Size> schedule;
  std::size_t round = 0;
  for (int leaves = 2; leaves <= Size - 2; ++leaves) {
    std::size_t lane = 0;
    for (std::uint32_t set = 0; set < schedule.kWhole; ++set) {
      if (std::popcount(set) != leaves) continue;
      if (lane == schedule.kLanes) ++round, lane = 0;
      schedule.leaves[round] = leaves;
      schedule.sets[round][lane++] = std::uint8_t(set);
    }
    ++round;
  }
  return schedule;
}

/// As for_each_partition of subset_tables.h, in a loop whose length the compiler knows.
template <int Leaves, class Visit>
TREELET_HD constexpr void for_each_partition_of(std::uint32_t set, Visit&& visit) {
  const std::uint32_t movable = set & (set - 1);
  std::uint32_t part = 0;
  for (int i = 1; i < 1 << (Leaves - 1); ++i) {
    part = (part - movable) & movable;
    visit(part);
  }
}

/// The set of all leaves but one that this lane and its three neighbours solve; there are 4 * Size
/// such lanes.
template <int Size>
TREELET_HD constexpr std::uint32_t quad_set(unsigned lane) {
  return TreeletSchedule<Size>::kWhole ^ (1u << (lane / 4));
}

/// This lane's share of the partitions of its quad's set.
template <int Size, class Visit>
TREELET_HD constexpr void for_each_partition_of_quad(unsigned lane, Visit&& visit) {
  const std::uint32_t set = quad_set<Size>(lane), movable = set & (set - 1);
  const std::uint32_t without_first = movable & (movable - 1);
  const std::uint32_t others = without_first & (without_first - 1);
  const std::uint32_t fixed = ((lane & 1) != 0 ? movable ^ without_first : 0) |
                              ((lane & 2) != 0 ? without_first ^ others : 0);
  std::uint32_t part = 0;
  for (int i = 0; i < 1 << (Size - 4); ++i) {
    if ((fixed | part) != 0) visit(fixed | part);
    part = (part - others) & others;
  }
}

/// This lane's share of the partitions of the whole treelet. The parts are even numbers, of which
/// 32 in a row lie in 16 banks of shared memory: the upper half of the warp takes the other part.
template <int Size, class Visit>
TREELET_HD constexpr void for_each_partition_of_whole(unsigned lane, Visit&& visit) {
  constexpr std::uint32_t kWhole = TreeletSchedule<Size>::kWhole;
  constexpr std::uint32_t kPartitions = kWhole / 2;
  for (std::uint32_t first = 1; first <= kPartitions; first += TreeletSchedule<Size>::kLanes) {
    const std::uint32_t part = 2 * (first + lane);
    if (part < kWhole) visit(lane < TreeletSchedule<Size>::kLanes / 2 ? part : kWhole ^ part);
  }
}

/// Calls visit(moment, set, part) for all that the lanes do: moments are what __syncwarp parts.
template <int Size, class Visit>
constexpr void for_each_scheduled_partition(Visit&& visit) {
  constexpr TreeletSchedule<Size> kSchedule = make_treelet_schedule<Size>();
  const auto visit_round = [&]<std::size_t Round>() {
    for (const std::uint32_t set : kSchedule.sets[Round]) {
      if (set == 0) continue;
      for_each_partition_of<kSchedule.leaves[Round]>(
          set, [&](std::uint32_t part) { visit(int(Round), set, part); });
    }
  };
  [&]<std::size_t... Round>(std::index_sequence<Round...>) {
    (visit_round.template operator()<Round>(), ...);
  }(std::make_index_sequence<std::size_t(kSchedule.kRounds)>());
  for (unsigned lane = 0; lane < 4 * Size; ++lane) {
    for_each_partition_of_quad<Size>(
        lane, [&](std::uint32_t part) { visit(kSchedule.kRounds, quad_set<Size>(lane), part); });
  }
  for (unsigned lane = 0; lane < kSchedule.kLanes; ++lane) {
    for_each_partition_of_whole<Size>(
        lane, [&](std::uint32_t part) { visit(kSchedule.kRounds + 1, kSchedule.kWhole, part); });
  }
}

/// Whether each partition of each subset is tried once, and what it reads is known by then.
template <int Size>
constexpr bool is_sound_treelet_schedule() {
  constexpr std::size_t kSubsets = std::size_t{1} << Size;
  struct Subset {
    int moment = -1;                    // when it was solved; single leaves are known before
    std::array<std::uint64_t, 4> seen;  // a bit for each part without the lowest leaf
  };
  std::array<Subset, kSubsets> subsets{};
  int partitions = 0;
  bool is_sound = true;
  for_each_scheduled_partition<Size>([&](int moment, std::uint32_t set, std::uint32_t part) {
    const std::uint32_t lowest = set & (0 - set), rest = set ^ part;
    const std::uint32_t name = (part & lowest) != 0 ? rest : part;
    const std::uint64_t bit = std::uint64_t{1} << name % 64;
    std::uint64_t& seen = subsets[set].seen[name / 64];
    is_sound = is_sound && (part & ~set) == 0 && part != 0 && rest != 0 && (seen & bit) == 0;
    is_sound = is_sound && subsets[part].moment < moment && subsets[rest].moment < moment;
    is_sound = is_sound && (subsets[set].moment == -1 || subsets[set].moment == moment);
    is_sound = is_sound && (std::has_single_bit(part) || subsets[part].moment >= 0);
    is_sound = is_sound && (std::has_single_bit(rest) || subsets[rest].moment >= 0);
    seen |= bit;
    subsets[set].moment = moment;
    ++partitions;
  });
  return is_sound && partitions == count_partitions(Size);
}
static_assert(is_sound_treelet_schedule<4>() && is_sound_treelet_schedule<5>() &&
              is_sound_treelet_schedule<6>() && is_sound_treelet_schedule<7>() &&
              is_sound_treelet_schedule<8>());

}  // namespace treelet
