#pragma once

#include <cstddef>
#include <functional>
#include <tuple>
#include <type_traits>
#include <utility>

#include "emulator/runtime_types.h"

// Launches of kernels and of what else a stream runs.

namespace treelet::emulator {

/// What each thread of a grid calls.
using ThreadBody = std::function<void()>;

/// Enqueues a grid, or says what is wrong with its configuration.
cudaError_t launch_grid(const cudaLaunchConfig_t& config, const void* kernel, ThreadBody body);
/// Enqueues work of the host in the place of a library's kernels, such as CUB's.
cudaError_t enqueue(cudaStream_t stream, std::function<void()> work);
cudaError_t check_function(const void* kernel);
cudaError_t get_function_attributes(cudaFuncAttributes* attributes, const void* kernel);
cudaError_t get_occupancy(int* blocks, const void* kernel, int threads, std::size_t shared_bytes);

template <class... Parameters, std::size_t... i>
ThreadBody bind_pointers(void (*kernel)(Parameters...), void** arguments,
                         std::index_sequence<i...>) {
  std::tuple<std::decay_t<Parameters>...> values(
      *static_cast<std::decay_t<Parameters>*>(arguments[i])...);
  return [kernel, values] { std::apply(kernel, values); };
}

}  // namespace treelet::emulator

/// Takes the kernel itself where CUDA takes any pointer: its type says how large the arguments are.
template <class... Parameters>
cudaError_t cudaLaunchKernelExC(const cudaLaunchConfig_t* config, void (*kernel)(Parameters...),
                                void** arguments) {
  using namespace treelet::emulator;
  return launch_grid(*config, reinterpret_cast<const void*>(kernel),
                     bind_pointers(kernel, arguments, std::index_sequence_for<Parameters...>()));
}

template <class... Parameters, class... Arguments>
cudaError_t cudaLaunchKernelEx(const cudaLaunchConfig_t* config, void (*kernel)(Parameters...),
                               Arguments&&... arguments) {
  std::tuple<std::decay_t<Parameters>...> values(std::forward<Arguments>(arguments)...);
  return treelet::emulator::launch_grid(*config, reinterpret_cast<const void*>(kernel),
                                        [kernel, values] { std::apply(kernel, values); });
}

template <class... Parameters>
cudaError_t cudaLaunchKernel(void (*kernel)(Parameters...), dim3 grid, dim3 block, void** arguments,
                             std::size_t shared_bytes = 0, cudaStream_t stream = nullptr) {
  const cudaLaunchConfig_t config{grid, block, shared_bytes, stream, nullptr, 0};
  return cudaLaunchKernelExC(&config, kernel, arguments);
}

template <class... Parameters>
cudaError_t cudaFuncSetAttribute(void (*kernel)(Parameters...), cudaFuncAttribute, int) {
  return treelet::emulator::check_function(reinterpret_cast<const void*>(kernel));
}
template <class... Parameters>
cudaError_t cudaFuncGetAttributes(cudaFuncAttributes* attributes, void (*kernel)(Parameters...)) {
  return treelet::emulator::get_function_attributes(attributes,
                                                    reinterpret_cast<const void*>(kernel));
}
template <class... Parameters>
cudaError_t cudaOccupancyMaxActiveBlocksPerMultiprocessor(int* blocks,
                                                          void (*kernel)(Parameters...),
                                                          int threads, std::size_t shared_bytes) {
  return treelet::emulator::get_occupancy(blocks, reinterpret_cast<const void*>(kernel), threads,
                                          shared_bytes);
}
