#pragma once

#include <cstdint>

#if __has_include(<emulator/control.h>)
#include <emulator/control.h>
#endif

namespace treelet::test {

/// Calls body(seed) under several orders of the device's threads; a real device chooses its own.
template <class Body>
void for_each_schedule(Body&& body) {
#if __has_include(<emulator/control.h>)
  for (const std::uint64_t seed : {0, 1, 2, 3}) {
    emulator::Settings settings = emulator::settings();
    settings.seed = seed;
    const emulator::SettingsScope scope(settings);
    body(seed);
  }
#else
  for (const std::uint64_t seed : {0, 1, 2, 3}) body(seed);
#endif
}

}  // namespace treelet::test
