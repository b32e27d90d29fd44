#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <numeric>
#include <type_traits>
#include <vector>

#include "cub/temporary_storage.h"

// Stands in for CUB's header of the same name.

namespace treelet::emulator {

/// The bits of a key, in whose order CUB sorts: negative numbers before positive ones.
template <class Key>
std::uint64_t to_ordered_bits(Key key) {
  using Bits = std::conditional_t<
      sizeof(Key) == 1, std::uint8_t,
      std::conditional_t<sizeof(Key) == 2, std::uint16_t,
                         std::conditional_t<sizeof(Key) == 4, std::uint32_t, std::uint64_t>>>;
  constexpr Bits kSign = Bits(Bits(1) << (8 * sizeof(Bits) - 1));
  const Bits bits = std::bit_cast<Bits>(key);
  if constexpr (std::is_floating_point_v<Key>) {
    if (key == Key(0)) return kSign;  // -0 is sorted as +0
    return (bits & kSign) != 0 ? Bits(~bits) : Bits(bits | kSign);
  } else if constexpr (std::is_signed_v<Key>) {
    return Bits(bits ^ kSign);
  } else {
    return bits;
  }
}

/// Indices of keys in the order of their bits [begin, end), equal ones as they were.
template <class Key>
std::vector<std::size_t> sort_indices(const Key* keys, std::size_t count, int begin_bit,
                                      int end_bit, bool descending) {
  const int width = end_bit - begin_bit;
  const std::uint64_t mask = width >= 64 ? ~0ull : (1ull << width) - 1;
  std::vector<std::uint64_t> bits(count);
  for (std::size_t i = 0; i < count; ++i) bits[i] = to_ordered_bits(keys[i]) >> begin_bit & mask;
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t(0));
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return descending ? bits[a] > bits[b] : bits[a] < bits[b];
  });
  return order;
}

template <class T>
void gather(const T* from, T* to, const std::vector<std::size_t>& order) {
  std::vector<T> gathered(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) gathered[i] = from[order[i]];
  std::copy(gathered.begin(), gathered.end(), to);
}

template <class T>
void overwrite(T* values, std::size_t count) {
  std::memset(static_cast<void*>(values), kStorageGarbage, count * sizeof(T));
}

}  // namespace treelet::emulator

namespace cub {

template <class T>
struct DoubleBuffer {
  T* d_buffers[2] = {nullptr, nullptr};
  int selector = 0;

  DoubleBuffer() = default;
  DoubleBuffer(T* current, T* alternate) : d_buffers{current, alternate} {}
  T* Current() { return d_buffers[selector]; }
  T* Alternate() { return d_buffers[selector ^ 1]; }
};

/// Tag for sorts without values.
struct NullType {};

struct DeviceRadixSort {
  template <class Key, class Value, class Count>
  static cudaError_t SortPairs(void* storage, std::size_t& storage_bytes, const Key* keys_in,
                               Key* keys_out, const Value* values_in, Value* values_out,
                               Count count, int begin_bit = 0, int end_bit = sizeof(Key) * 8,
                               cudaStream_t stream = nullptr) {
    return sort(storage, storage_bytes, keys_in, keys_out, values_in, values_out,
                std::size_t(count), begin_bit, end_bit, stream, Order::kAscending);
  }
  template <class Key, class Value, class Count>
  static cudaError_t SortPairsDescending(void* storage, std::size_t& storage_bytes,
                                         const Key* keys_in, Key* keys_out, const Value* values_in,
                                         Value* values_out, Count count, int begin_bit = 0,
                                         int end_bit = sizeof(Key) * 8,
                                         cudaStream_t stream = nullptr) {
    return sort(storage, storage_bytes, keys_in, keys_out, values_in, values_out,
                std::size_t(count), begin_bit, end_bit, stream, Order::kDescending);
  }
  template <class Key, class Count>
  static cudaError_t SortKeys(void* storage, std::size_t& storage_bytes, const Key* keys_in,
                              Key* keys_out, Count count, int begin_bit = 0,
                              int end_bit = sizeof(Key) * 8, cudaStream_t stream = nullptr) {
    return sort<Key, NullType>(storage, storage_bytes, keys_in, keys_out, nullptr, nullptr,
                               std::size_t(count), begin_bit, end_bit, stream, Order::kAscending);
  }

  /// Leaves the result in the alternate buffers and garbage in the others; CUB may do either.
  template <class Key, class Value, class Count>
  static cudaError_t SortPairs(void* storage, std::size_t& storage_bytes, DoubleBuffer<Key>& keys,
                               DoubleBuffer<Value>& values, Count count, int begin_bit = 0,
                               int end_bit = sizeof(Key) * 8, cudaStream_t stream = nullptr) {
    using namespace treelet::emulator;
    Key *keys_in = keys.Current(), *keys_out = keys.Alternate();
    Value *values_in = values.Current(), *values_out = values.Alternate();
    const bool runs = storage != nullptr;
    const std::size_t n = std::size_t(count);
    const cudaError_t error = run_with_storage(storage, storage_bytes, n, stream, [=] {
      run(keys_in, keys_out, values_in, values_out, n, begin_bit, end_bit, Order::kAscending);
      overwrite(keys_in, n);
      overwrite(values_in, n);
    });
    if (runs && error == cudaSuccess) keys.selector ^= 1, values.selector ^= 1;
    return error;
  }
  template <class Key, class Count>
  static cudaError_t SortKeys(void* storage, std::size_t& storage_bytes, DoubleBuffer<Key>& keys,
                              Count count, int begin_bit = 0, int end_bit = sizeof(Key) * 8,
                              cudaStream_t stream = nullptr) {
    using namespace treelet::emulator;
    Key *keys_in = keys.Current(), *keys_out = keys.Alternate();
    const bool runs = storage != nullptr;
    const std::size_t n = std::size_t(count);
    const cudaError_t error = run_with_storage(storage, storage_bytes, n, stream, [=] {
      run<Key, NullType>(keys_in, keys_out, nullptr, nullptr, n, begin_bit, end_bit,
                         Order::kAscending);
      overwrite(keys_in, n);
    });
    if (runs && error == cudaSuccess) keys.selector ^= 1;
    return error;
  }

 private:
  enum class Order { kAscending, kDescending };

  template <class Key, class Value>
  static void run(const Key* keys_in, Key* keys_out, const Value* values_in, Value* values_out,
                  std::size_t count, int begin_bit, int end_bit, Order direction) {
    using namespace treelet::emulator;
    const auto order =
        sort_indices(keys_in, count, begin_bit, end_bit, direction == Order::kDescending);
    gather(keys_in, keys_out, order);
    if constexpr (!std::is_same_v<Value, NullType>) gather(values_in, values_out, order);
  }

  template <class Key, class Value>
  static cudaError_t sort(void* storage, std::size_t& storage_bytes, const Key* keys_in,
                          Key* keys_out, const Value* values_in, Value* values_out,
                          std::size_t count, int begin_bit, int end_bit, cudaStream_t stream,
                          Order direction) {
    const int key_bits = 8 * int(sizeof(Key));
    if (begin_bit < 0 || begin_bit > end_bit || end_bit > key_bits) return cudaErrorInvalidValue;
    return treelet::emulator::run_with_storage(storage, storage_bytes, count, stream, [=] {
      run(keys_in, keys_out, values_in, values_out, count, begin_bit, end_bit, direction);
    });
  }
};

}  // namespace cub
