#pragma once

#include <iterator>
#include <limits>

#include "cub/temporary_storage.h"

// Stands in for CUB's header of the same name.

namespace cub {

struct DeviceReduce {
  template <class In, class Out, class Count, class Combine, class Initial>
  static cudaError_t Reduce(void* storage, std::size_t& storage_bytes, In in, Out out, Count count,
                            Combine combine, Initial initial, cudaStream_t stream = nullptr) {
    return treelet::emulator::run_with_storage(storage, storage_bytes, std::size_t(count), stream,
                                               [=] {
                                                 Initial total = initial;
                                                 for (Count i = 0; i < count; ++i)
                                                   total = Initial(combine(total, in[i]));
                                                 *out = total;
                                               });
  }

  template <class In, class Out, class Count>
  static cudaError_t Sum(void* storage, std::size_t& storage_bytes, In in, Out out, Count count,
                         cudaStream_t stream = nullptr) {
    using T = typename std::iterator_traits<In>::value_type;
    const auto add = [](const T& a, const T& b) { return T(a + b); };
    return Reduce(storage, storage_bytes, in, out, count, add, T{}, stream);
  }
  template <class In, class Out, class Count>
  static cudaError_t Max(void* storage, std::size_t& storage_bytes, In in, Out out, Count count,
                         cudaStream_t stream = nullptr) {
    using T = typename std::iterator_traits<In>::value_type;
    const auto larger = [](const T& a, const T& b) { return a < b ? b : a; };
    return Reduce(storage, storage_bytes, in, out, count, larger, std::numeric_limits<T>::lowest(),
                  stream);
  }
  template <class In, class Out, class Count>
  static cudaError_t Min(void* storage, std::size_t& storage_bytes, In in, Out out, Count count,
                         cudaStream_t stream = nullptr) {
    using T = typename std::iterator_traits<In>::value_type;
    const auto smaller = [](const T& a, const T& b) { return b < a ? b : a; };
    return Reduce(storage, storage_bytes, in, out, count, smaller, std::numeric_limits<T>::max(),
                  stream);
  }
};

}  // namespace cub
