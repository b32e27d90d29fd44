#pragma once

#include "cub/temporary_storage.h"

// Stands in for CUB's header of the same name.

namespace cub {

struct DeviceSelect {
  template <class In, class Flags, class Out, class Selected, class Count>
  static cudaError_t Flagged(void* storage, std::size_t& storage_bytes, In in, Flags flags, Out out,
                             Selected selected, Count count, cudaStream_t stream = nullptr) {
    return select(storage, storage_bytes, in, out, selected, count, stream,
                  [=](Count i) { return bool(flags[i]); });
  }

  template <class In, class Out, class Selected, class Count, class Predicate>
  static cudaError_t If(void* storage, std::size_t& storage_bytes, In in, Out out,
                        Selected selected, Count count, Predicate predicate,
                        cudaStream_t stream = nullptr) {
    return select(storage, storage_bytes, in, out, selected, count, stream,
                  [=](Count i) { return bool(predicate(in[i])); });
  }

 private:
  template <class In, class Out, class Selected, class Count, class IsWanted>
  static cudaError_t select(void* storage, std::size_t& storage_bytes, In in, Out out,
                            Selected selected, Count count, cudaStream_t stream, IsWanted wanted) {
    return treelet::emulator::run_with_storage(storage, storage_bytes, std::size_t(count), stream,
                                               [=] {
                                                 Count taken = 0;
                                                 for (Count i = 0; i < count; ++i) {
                                                   if (wanted(i)) out[taken++] = in[i];
                                                 }
                                                 *selected = taken;
                                               });
  }
};

}  // namespace cub
