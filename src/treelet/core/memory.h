#pragma once

#include <cstddef>

namespace treelet {

/// Uninitialised memory on a cache-line boundary; large blocks ask for huge pages, which a
/// traversal's random reads notice. Throws std::bad_alloc.
void* allocate_bytes(std::size_t bytes);
void free_bytes(void* memory) noexcept;

/// Makes the address sanitizer, where there is one, report who touches these bytes; and no longer.
void poison_bytes(void* memory, std::size_t bytes) noexcept;
void unpoison_bytes(void* memory, std::size_t bytes) noexcept;

}  // namespace treelet
