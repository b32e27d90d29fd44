#pragma once

#include <algorithm>
#include <cstddef>
#include <type_traits>
#include <vector>

namespace treelet {

/// Threads that work on a parallel loop, the caller included.
unsigned thread_count();

/// 0 means one a hardware thread; loops run with fewer where the system gives no more. Loops
/// already running finish with the threads they have.
void set_thread_count(unsigned count);

namespace detail {
using ChunkFunction = void (*)(void* context, std::size_t chunk);
/// Calls function(context, c) once for each c < chunk_count, on any thread and in any order, and
/// returns when all are done. Rethrows the first exception. Calls may nest.
void run_chunks(std::size_t chunk_count, ChunkFunction function, void* context);
}  // namespace detail

/// Calls body(begin, end) for the ranges of `grain` indices that make up [0, count). The ranges do
/// not depend on the number of threads, so a body that writes only to its range is deterministic.
template <class Body>
void parallel_for_ranges(std::size_t count, std::size_t grain, Body&& body) {
  if (count == 0) return;
  auto run = [&](std::size_t chunk) {
    const std::size_t begin = chunk * grain;
    body(begin, std::min(begin + grain, count));
  };
  using Run = decltype(run);
  detail::run_chunks((count + grain - 1) / grain,
                     [](void* context, std::size_t chunk) { (*static_cast<Run*>(context))(chunk); },
                     &run);
}

/// Calls body(i) for each i in [0, count).
template <class Body>
void parallel_for(std::size_t count, std::size_t grain, Body&& body) {
  parallel_for_ranges(count, grain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) body(i);
  });
}

/// Combines map(begin, end) of consecutive ranges in index order: also a sum of floats is the same
/// for any number of threads.
template <class T, class Map, class Combine>
T parallel_reduce(std::size_t count, std::size_t grain, T identity, Map&& map, Combine&& combine) {
  std::vector<T> partial((count + grain - 1) / grain, identity);
  parallel_for_ranges(count, grain, [&](std::size_t begin, std::size_t end) {
    partial[begin / grain] = map(begin, end);
  });
  T result = identity;
  for (const T& p : partial) result = combine(result, p);
  return result;
}

}  // namespace treelet
