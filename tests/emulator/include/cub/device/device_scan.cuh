#pragma once

#include <iterator>
#include <type_traits>
#include <utility>

#include "cub/temporary_storage.h"

// Stands in for CUB's header of the same name.

namespace cub {

struct DeviceScan {
  template <class In, class Out, class Count>
  static cudaError_t ExclusiveSum(void* storage, std::size_t& storage_bytes, In in, Out out,
                                  Count count, cudaStream_t stream = nullptr) {
    return ExclusiveScan(storage, storage_bytes, in, out, Plus(), value_type<In>{}, count, stream);
  }
  template <class InOut, class Count>
    requires std::is_integral_v<Count>
  static cudaError_t ExclusiveSum(void* storage, std::size_t& storage_bytes, InOut values,
                                  Count count, cudaStream_t stream = nullptr) {
    return ExclusiveSum(storage, storage_bytes, values, values, count, stream);
  }
  template <class In, class Out, class Count>
  static cudaError_t InclusiveSum(void* storage, std::size_t& storage_bytes, In in, Out out,
                                  Count count, cudaStream_t stream = nullptr) {
    return InclusiveScan(storage, storage_bytes, in, out, Plus(), count, stream);
  }
  template <class InOut, class Count>
    requires std::is_integral_v<Count>
  static cudaError_t InclusiveSum(void* storage, std::size_t& storage_bytes, InOut values,
                                  Count count, cudaStream_t stream = nullptr) {
    return InclusiveSum(storage, storage_bytes, values, values, count, stream);
  }

  template <class In, class Out, class Combine, class Initial, class Count>
  static cudaError_t ExclusiveScan(void* storage, std::size_t& storage_bytes, In in, Out out,
                                   Combine combine, Initial initial, Count count,
                                   cudaStream_t stream = nullptr) {
    return treelet::emulator::run_with_storage(
        storage, storage_bytes, std::size_t(count), stream, [=] {
          Initial sum = initial;
          for (Count i = 0; i < count; ++i) {
            const Initial before = sum;  // in and out may be the same
            sum = Initial(combine(sum, in[i]));
            out[i] = before;
          }
        });
  }
  template <class In, class Out, class Combine, class Count>
  static cudaError_t InclusiveScan(void* storage, std::size_t& storage_bytes, In in, Out out,
                                   Combine combine, Count count, cudaStream_t stream = nullptr) {
    return treelet::emulator::run_with_storage(
        storage, storage_bytes, std::size_t(count), stream, [=] {
          if (count == 0) return;
          value_type<In> sum = in[0];
          out[0] = sum;
          for (Count i = 1; i < count; ++i) out[i] = sum = value_type<In>(combine(sum, in[i]));
        });
  }

 private:
  template <class Iterator>
  using value_type = typename std::iterator_traits<Iterator>::value_type;

  struct Plus {
    template <class T>
    T operator()(const T& a, const T& b) const {
      return T(a + b);
    }
  };
};

}  // namespace cub
