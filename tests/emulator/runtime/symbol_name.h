#pragma once

#include <cstddef>

namespace treelet::emulator {

/// Writes the name of the function at this address, or the address where the program's file does
/// not tell.
void find_symbol_name(const void* address, char* name, std::size_t capacity);

}  // namespace treelet::emulator
