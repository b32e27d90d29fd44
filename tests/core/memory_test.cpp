#include <treelet/core/memory.h>

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <limits>
#include <new>

namespace treelet {
namespace {

TEST(AllocateBytes, AlignsToCacheLines) {
  for (const std::size_t bytes : {1u, 63u, 64u, 65u, 4096u, 5u << 20}) {
    void* memory = allocate_bytes(bytes);
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(memory) % 64, 0u) << bytes << " bytes";
    std::memset(memory, 0x5a, bytes);  // for the address sanitizer
    free_bytes(memory);
  }
}

TEST(AllocateBytes, RefusesASizeThatRoundsUpToZero) {
  EXPECT_THROW(allocate_bytes(std::numeric_limits<std::size_t>::max()), std::bad_alloc);
}

TEST(FreeBytes, IgnoresNull) { free_bytes(nullptr); }

}  // namespace
}  // namespace treelet
