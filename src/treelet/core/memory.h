#pragma once

#include <cstddef>

namespace treelet {

/// Uninitialised memory on a cache-line boundary; large blocks ask for huge pages, which a
/// traversal's random reads notice. Throws std::bad_alloc.
void* allocate_bytes(std::size_t bytes);
void free_bytes(void* memory) noexcept;

}  // namespace treelet
