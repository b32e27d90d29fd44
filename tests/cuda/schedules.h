#pragma once

#include <cstdint>

#if __has_include(<emulator/control.h>)
#include <emulator/control.h>
#endif

namespace treelet::test {

/// Calls body() under the order of the device's threads that belongs to the seed; a real device
/// chooses its own.
template <class Body>
void with_schedule(std::uint64_t seed, Body&& body) {
#if __has_include(<emulator/control.h>)
  emulator::Settings settings = emulator::settings();
  settings.seed = seed;
  const emulator::SettingsScope scope(settings);
#endif
  body();
}

/// Calls body(seed) under several orders of the device's threads; a real device chooses its own.
template <class Body>
void for_each_schedule(Body&& body) {
  for (const std::uint64_t seed : {0, 1, 2, 3}) {
    with_schedule(seed, [&] { body(seed); });
  }
}

}  // namespace treelet::test
