#pragma once

#include <cstddef>
#include <cstdint>

// What tests set and ask, beside the CUDA runtime.

namespace treelet::emulator {

struct Settings {
  /// Threads of the host that run blocks.
  unsigned workers = 3;
  /// 0 runs the threads of a block in turns; any other seed in an order of its own, with
  /// pre-emption at atomics and fences.
  std::uint64_t seed = 0;
  /// Without a device all calls fail with cudaErrorNoDevice.
  bool has_device = true;
  /// Allocations above it fail with cudaErrorMemoryAllocation.
  std::size_t memory_limit = std::size_t(64) << 30;
};

/// At first from TREELET_EMULATOR_{WORKERS,SEED,NO_DEVICE,MEMORY_LIMIT} of the environment.
Settings settings();
void set_settings(const Settings& settings);

/// Changes the settings for its lifetime.
class SettingsScope {
 public:
  explicit SettingsScope(const Settings& wanted) : before_(settings()) { set_settings(wanted); }
  ~SettingsScope() { set_settings(before_); }
  SettingsScope(const SettingsScope&) = delete;
  SettingsScope& operator=(const SettingsScope&) = delete;

 private:
  Settings before_;
};

/// Device and pinned memory that is allocated now.
std::size_t allocation_count();
std::size_t allocated_bytes();
/// Kernels launched since the program began.
std::uint64_t launch_count();

}  // namespace treelet::emulator
