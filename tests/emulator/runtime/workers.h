#pragma once

#include "launch_record.h"

namespace treelet::emulator {

/// Runs all blocks of a grid, several at a time, and returns when they are done.
void run_grid(const LaunchRecord& launch, unsigned workers);

}  // namespace treelet::emulator
