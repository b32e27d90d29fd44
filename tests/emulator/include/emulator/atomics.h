#pragma once

#include <algorithm>
#include <atomic>
#include <concepts>
#include <type_traits>

#include "emulator/engine.h"

// CUDA's atomic functions: relaxed, at device scope. They take the types that CUDA takes; note that
// std::uint64_t is unsigned long on Linux, which CUDA does not take.

namespace treelet::emulator {

template <class T, class... Choices>
concept OneOf = (std::same_as<T, Choices> || ...);

template <class T>
concept AddOperand = OneOf<T, int, unsigned, unsigned long long, float, double>;
template <class T>
concept SubtractOperand = OneOf<T, int, unsigned>;
template <class T>
concept ExchangeOperand = OneOf<T, int, unsigned, unsigned long long, float>;
template <class T>
concept CompareOperand = OneOf<T, int, unsigned, unsigned long long, unsigned short>;
template <class T>
concept OrderOperand = OneOf<T, int, unsigned, long long, unsigned long long>;
template <class T>
concept BitOperand = OneOf<T, int, unsigned, unsigned long long>;

/// Replaces *address by change(*address) and returns what was there.
template <class T, class Change>
T fetch_and_change(T* address, std::memory_order order, Change change) {
  std::atomic_ref<T> target(*address);
  T old = target.load(std::memory_order_relaxed);
  while (!target.compare_exchange_weak(old, change(old), order, std::memory_order_relaxed)) {
  }
  return old;
}

}  // namespace treelet::emulator

template <treelet::emulator::AddOperand T>
T atomicAdd(T* address, std::type_identity_t<T> value) {
  treelet::emulator::preempt();
  return std::atomic_ref<T>(*address).fetch_add(value, std::memory_order_relaxed);
}
template <treelet::emulator::SubtractOperand T>
T atomicSub(T* address, std::type_identity_t<T> value) {
  treelet::emulator::preempt();
  return std::atomic_ref<T>(*address).fetch_sub(value, std::memory_order_relaxed);
}
template <treelet::emulator::ExchangeOperand T>
T atomicExch(T* address, std::type_identity_t<T> value) {
  treelet::emulator::preempt();
  return std::atomic_ref<T>(*address).exchange(value, std::memory_order_relaxed);
}
template <treelet::emulator::CompareOperand T>
T atomicCAS(T* address, std::type_identity_t<T> expected, std::type_identity_t<T> desired) {
  treelet::emulator::preempt();
  std::atomic_ref<T>(*address).compare_exchange_strong(expected, desired,
                                                       std::memory_order_relaxed);
  return expected;
}
template <treelet::emulator::OrderOperand T>
T atomicMin(T* address, std::type_identity_t<T> value) {
  treelet::emulator::preempt();
  return treelet::emulator::fetch_and_change(address, std::memory_order_relaxed,
                                             [=](T old) { return std::min(old, value); });
}
template <treelet::emulator::OrderOperand T>
T atomicMax(T* address, std::type_identity_t<T> value) {
  treelet::emulator::preempt();
  return treelet::emulator::fetch_and_change(address, std::memory_order_relaxed,
                                             [=](T old) { return std::max(old, value); });
}
template <treelet::emulator::BitOperand T>
T atomicAnd(T* address, std::type_identity_t<T> value) {
  treelet::emulator::preempt();
  return std::atomic_ref<T>(*address).fetch_and(value, std::memory_order_relaxed);
}
template <treelet::emulator::BitOperand T>
T atomicOr(T* address, std::type_identity_t<T> value) {
  treelet::emulator::preempt();
  return std::atomic_ref<T>(*address).fetch_or(value, std::memory_order_relaxed);
}
template <treelet::emulator::BitOperand T>
T atomicXor(T* address, std::type_identity_t<T> value) {
  treelet::emulator::preempt();
  return std::atomic_ref<T>(*address).fetch_xor(value, std::memory_order_relaxed);
}
