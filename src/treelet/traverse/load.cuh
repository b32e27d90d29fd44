#pragma once

#include <cstring>

#include <treelet/core/launch.cuh>

namespace treelet::cuda {

/// Reads what no thread of the kernel writes, by loads of a Chunk each: where memory is aligned for
/// them, one of 16 bytes costs what one of 4 does.
template <class Chunk, class T>
__device__ T load_by(const T* from) {
  static_assert(sizeof(T) % sizeof(Chunk) == 0);
  constexpr int kChunks = sizeof(T) / sizeof(Chunk);
  const auto* chunks = reinterpret_cast<const Chunk*>(from);
  Chunk raw[kChunks];
  for (int i = 0; i < kChunks; ++i) raw[i] = __ldg(chunks + i);
  T value;
  std::memcpy(&value, raw, sizeof(T));
  return value;
}

}  // namespace treelet::cuda
