#pragma once

#include <atomic>
#include <type_traits>

#include "emulator/atomics.h"

// nvcc's built-in atomics with memory order and scope. A thread of the host sees all scopes alike.

#define __NV_ATOMIC_RELAXED 0
#define __NV_ATOMIC_CONSUME 1
#define __NV_ATOMIC_ACQUIRE 2
#define __NV_ATOMIC_RELEASE 3
#define __NV_ATOMIC_ACQ_REL 4
#define __NV_ATOMIC_SEQ_CST 5

#define __NV_THREAD_SCOPE_THREAD 0
#define __NV_THREAD_SCOPE_BLOCK 1
#define __NV_THREAD_SCOPE_CLUSTER 2
#define __NV_THREAD_SCOPE_DEVICE 3
#define __NV_THREAD_SCOPE_SYSTEM 4

namespace treelet::emulator {

constexpr std::memory_order to_memory_order(int order) {
  constexpr std::memory_order kOrders[] = {std::memory_order_relaxed, std::memory_order_acquire,
                                           std::memory_order_acquire, std::memory_order_release,
                                           std::memory_order_acq_rel, std::memory_order_seq_cst};
  return kOrders[order];
}

}  // namespace treelet::emulator

template <class T>
T __nv_atomic_load_n(T* address, int order, int = __NV_THREAD_SCOPE_SYSTEM) {
  treelet::emulator::preempt();
  using Value = std::remove_const_t<T>;
  return std::atomic_ref<Value>(const_cast<Value&>(*address))
      .load(treelet::emulator::to_memory_order(order));
}
template <class T>
void __nv_atomic_load(T* address, std::remove_const_t<T>* result, int order,
                      int scope = __NV_THREAD_SCOPE_SYSTEM) {
  *result = __nv_atomic_load_n(address, order, scope);
}

template <class T>
void __nv_atomic_store_n(T* address, std::type_identity_t<T> value, int order,
                         int = __NV_THREAD_SCOPE_SYSTEM) {
  treelet::emulator::preempt();
  std::atomic_ref<T>(*address).store(value, treelet::emulator::to_memory_order(order));
}
template <class T>
void __nv_atomic_store(T* address, T* value, int order, int scope = __NV_THREAD_SCOPE_SYSTEM) {
  __nv_atomic_store_n(address, *value, order, scope);
}

template <class T>
T __nv_atomic_exchange_n(T* address, std::type_identity_t<T> value, int order,
                         int = __NV_THREAD_SCOPE_SYSTEM) {
  treelet::emulator::preempt();
  return std::atomic_ref<T>(*address).exchange(value, treelet::emulator::to_memory_order(order));
}
template <class T>
void __nv_atomic_exchange(T* address, T* value, T* result, int order,
                          int scope = __NV_THREAD_SCOPE_SYSTEM) {
  *result = __nv_atomic_exchange_n(address, *value, order, scope);
}

template <class T>
bool __nv_atomic_compare_exchange_n(T* address, T* expected, std::type_identity_t<T> desired,
                                    bool weak, int success, int failure,
                                    int = __NV_THREAD_SCOPE_SYSTEM) {
  using treelet::emulator::to_memory_order;
  treelet::emulator::preempt();
  std::atomic_ref<T> target(*address);
  return weak ? target.compare_exchange_weak(*expected, desired, to_memory_order(success),
                                             to_memory_order(failure))
              : target.compare_exchange_strong(*expected, desired, to_memory_order(success),
                                               to_memory_order(failure));
}
template <class T>
bool __nv_atomic_compare_exchange(T* address, T* expected, T* desired, bool weak, int success,
                                  int failure, int scope = __NV_THREAD_SCOPE_SYSTEM) {
  return __nv_atomic_compare_exchange_n(address, expected, *desired, weak, success, failure, scope);
}

#define TREELET_EMULATOR_FETCH(name, expression)                                                   \
  template <class T>                                                                               \
  T __nv_atomic_fetch_##name(T* address, std::type_identity_t<T> value, int order,                 \
                             int = __NV_THREAD_SCOPE_SYSTEM) {                                     \
    treelet::emulator::preempt();                                                                  \
    return treelet::emulator::fetch_and_change(address, treelet::emulator::to_memory_order(order), \
                                               [=](T old) { return T(expression); });              \
  }                                                                                                \
  template <class T>                                                                               \
  void __nv_atomic_##name(T* address, std::type_identity_t<T> value, int order,                    \
                          int scope = __NV_THREAD_SCOPE_SYSTEM) {                                  \
    __nv_atomic_fetch_##name(address, value, order, scope);                                        \
  }

TREELET_EMULATOR_FETCH(add, old + value)
TREELET_EMULATOR_FETCH(sub, old - value)
TREELET_EMULATOR_FETCH(min, old < value ? old : value)
TREELET_EMULATOR_FETCH(max, old > value ? old : value)
TREELET_EMULATOR_FETCH(and, old& value)
TREELET_EMULATOR_FETCH(or, old | value)
TREELET_EMULATOR_FETCH(xor, old ^ value)

#undef TREELET_EMULATOR_FETCH

inline void __nv_atomic_thread_fence(int, int = __NV_THREAD_SCOPE_SYSTEM) {
  treelet::emulator::fence();
}
