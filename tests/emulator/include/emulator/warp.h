#pragma once

#include <concepts>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "emulator/engine.h"

// Collective operations of warps and blocks.

namespace treelet::emulator {

template <class T>
constexpr ValueType kTypeOf = ValueType::kNone;
template <>
inline constexpr ValueType kTypeOf<int> = ValueType::kInt;
template <>
inline constexpr ValueType kTypeOf<unsigned> = ValueType::kUnsigned;
template <>
inline constexpr ValueType kTypeOf<long long> = ValueType::kLongLong;
template <>
inline constexpr ValueType kTypeOf<unsigned long long> = ValueType::kUnsignedLongLong;
template <>
inline constexpr ValueType kTypeOf<float> = ValueType::kFloat;
template <>
inline constexpr ValueType kTypeOf<double> = ValueType::kDouble;
// CUDA also has the overloads for long, which is as wide as long long here.
template <>
inline constexpr ValueType kTypeOf<long> = ValueType::kLongLong;
template <>
inline constexpr ValueType kTypeOf<unsigned long> = ValueType::kUnsignedLongLong;

/// What __shfl_sync and __match_any_sync take.
template <class T>
concept WarpValue = kTypeOf<T> != ValueType::kNone;
/// What __reduce_add_sync and its kind take.
template <class T>
concept WarpInteger = std::same_as<T, int> || std::same_as<T, unsigned>;

template <WarpValue T>
std::uint64_t to_bits(T value) {
  std::uint64_t bits = 0;
  std::memcpy(&bits, &value, sizeof value);
  return bits;
}

template <WarpValue T>
T from_bits(std::uint64_t bits) {
  T value;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

template <WarpValue T>
T shuffle(Operation operation, unsigned mask, T value, unsigned operand, int width) {
  return from_bits<T>(
      meet_warp({operation, kTypeOf<T>, mask, operand, unsigned(width), to_bits(value)}));
}

template <class T>
std::uint64_t meet(Operation operation, unsigned mask, T value) {
  return meet_warp({operation, kTypeOf<T>, mask, 0, 32, to_bits(value)});
}

}  // namespace treelet::emulator

inline void __syncwarp(unsigned mask = 0xffffffff) {
  using namespace treelet::emulator;
  meet_warp({Operation::kSyncWarp, ValueType::kNone, mask, 0, 32, 0});
}

template <treelet::emulator::WarpValue T>
T __shfl_sync(unsigned mask, T value, int lane, int width = 32) {
  using namespace treelet::emulator;
  return shuffle(Operation::kShuffle, mask, value, unsigned(lane), width);
}
template <treelet::emulator::WarpValue T>
T __shfl_up_sync(unsigned mask, T value, unsigned distance, int width = 32) {
  using namespace treelet::emulator;
  return shuffle(Operation::kShuffleUp, mask, value, distance, width);
}
template <treelet::emulator::WarpValue T>
T __shfl_down_sync(unsigned mask, T value, unsigned distance, int width = 32) {
  using namespace treelet::emulator;
  return shuffle(Operation::kShuffleDown, mask, value, distance, width);
}
template <treelet::emulator::WarpValue T>
T __shfl_xor_sync(unsigned mask, T value, int pattern, int width = 32) {
  using namespace treelet::emulator;
  return shuffle(Operation::kShuffleXor, mask, value, unsigned(pattern), width);
}

inline unsigned __ballot_sync(unsigned mask, int predicate) {
  using namespace treelet::emulator;
  return unsigned(meet(Operation::kBallot, mask, predicate));
}
inline int __any_sync(unsigned mask, int predicate) {
  using namespace treelet::emulator;
  return int(meet(Operation::kAny, mask, predicate));
}
inline int __all_sync(unsigned mask, int predicate) {
  using namespace treelet::emulator;
  return int(meet(Operation::kAll, mask, predicate));
}
template <treelet::emulator::WarpValue T>
unsigned __match_any_sync(unsigned mask, T value) {
  using namespace treelet::emulator;
  return unsigned(meet(Operation::kMatchAny, mask, value));
}

template <treelet::emulator::WarpInteger T>
T __reduce_add_sync(unsigned mask, T value) {
  using namespace treelet::emulator;
  return T(meet(Operation::kReduceAdd, mask, value));
}
template <treelet::emulator::WarpInteger T>
T __reduce_min_sync(unsigned mask, T value) {
  using namespace treelet::emulator;
  return T(meet(Operation::kReduceMin, mask, value));
}
template <treelet::emulator::WarpInteger T>
T __reduce_max_sync(unsigned mask, T value) {
  using namespace treelet::emulator;
  return T(meet(Operation::kReduceMax, mask, value));
}
inline unsigned __reduce_and_sync(unsigned mask, unsigned value) {
  using namespace treelet::emulator;
  return unsigned(meet(Operation::kReduceAnd, mask, value));
}
inline unsigned __reduce_or_sync(unsigned mask, unsigned value) {
  using namespace treelet::emulator;
  return unsigned(meet(Operation::kReduceOr, mask, value));
}
inline unsigned __reduce_xor_sync(unsigned mask, unsigned value) {
  using namespace treelet::emulator;
  return unsigned(meet(Operation::kReduceXor, mask, value));
}

/// Only the calling lane: the hardware may have diverged at any instruction before.
inline unsigned __activemask() { return treelet::emulator::own_lane_bit(); }

inline void __syncthreads() {
  using namespace treelet::emulator;
  meet_block(Operation::kSyncBlock, 0);
}
inline int __syncthreads_count(int predicate) {
  using namespace treelet::emulator;
  return meet_block(Operation::kSyncBlockCount, predicate);
}
inline int __syncthreads_and(int predicate) {
  using namespace treelet::emulator;
  return meet_block(Operation::kSyncBlockAnd, predicate);
}
inline int __syncthreads_or(int predicate) {
  using namespace treelet::emulator;
  return meet_block(Operation::kSyncBlockOr, predicate);
}

inline void __threadfence() { treelet::emulator::fence(); }
inline void __threadfence_block() { treelet::emulator::fence(); }
inline void __threadfence_system() { treelet::emulator::fence(); }
inline void __nanosleep(unsigned) { treelet::emulator::yield_thread(); }
[[noreturn]] inline void __trap() { treelet::emulator::fail("__trap()"); }
