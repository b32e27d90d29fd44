#include <treelet/core/arena.h>

#include <gtest/gtest.h>

#include <treelet/core/array.h>
#include <treelet/core/parallel.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <memory>
#include <new>
#include <optional>
#include <thread>
#include <vector>

#include "support/threads.h"

namespace treelet {
namespace {

constexpr std::size_t kMebibyte = std::size_t{1} << 20;

std::shared_ptr<Arena> make_arena() { return std::make_shared<Arena>(); }

/// Where an array of so many bytes lies that is made in the arena and dropped at once.
const char* touch(const std::shared_ptr<Arena>& arena, std::size_t bytes) {
  const ArenaScope scope(arena);
  Array<char> array(bytes);
  std::fill(array.begin(), array.end(), 'x');
  return array.data();
}

TEST(Arena, HandsABlockOutAgain) {
  const auto arena = make_arena();
  const char* const first = touch(arena, kMebibyte);
  EXPECT_EQ(touch(arena, kMebibyte), first);
  EXPECT_EQ(touch(arena, kMebibyte * 3 / 4), first);
  EXPECT_EQ(arena->bytes(), kMebibyte);
}

TEST(Arena, BlocksThatAreLentStayApart) {
  const auto arena = make_arena();
  const ArenaScope scope(arena);
  Array<std::uint32_t> a(1000, 1), b(1000, 2);
  EXPECT_EQ(std::count(a.begin(), a.end(), 1u), 1000);
  EXPECT_EQ(std::count(b.begin(), b.end(), 2u), 1000);
}

TEST(Arena, DoesNotLendABlockOfMoreThanTwiceTheSize) {
  const auto arena = make_arena();
  const char* const large = touch(arena, kMebibyte);
  EXPECT_NE(touch(arena, kMebibyte / 3), large);
}

TEST(Arena, TakesTheSmallestBlockThatFits) {
  const auto arena = make_arena();
  const char *large, *small;
  {
    const ArenaScope scope(arena);
    const Array<char> a(kMebibyte), b(kMebibyte / 4 * 3);
    large = a.data();
    small = b.data();
  }
  EXPECT_EQ(touch(arena, kMebibyte / 8 * 5), small);
  EXPECT_EQ(touch(arena, kMebibyte / 8 * 7), large);
}

TEST(Arena, ALittleMoreFitsIntoTheSameBlock) {
  const auto arena = make_arena();
  const char* const first = touch(arena, 1000001);
  EXPECT_EQ(touch(arena, 1000100), first);
  EXPECT_LE(arena->bytes(), 1000001u * 9 / 8 + 64);
}

TEST(Arena, AlignsToCacheLines) {
  const auto arena = make_arena();
  const ArenaScope scope(arena);
  for (std::size_t size = 1; size < 200; ++size) {
    const Array<char> array(size);
    ASSERT_EQ(reinterpret_cast<std::uintptr_t>(array.data()) % 64, 0u);
  }
}

TEST(Arena, ReleasesWhatLayIdleBetweenTwoCalls) {
  const auto arena = make_arena();
  touch(arena, kMebibyte);
  touch(arena, 8 * kMebibyte);
  arena->release_idle();  // both were used
  EXPECT_EQ(arena->bytes(), 9 * kMebibyte);
  touch(arena, kMebibyte);
  arena->release_idle();
  EXPECT_EQ(arena->bytes(), kMebibyte);
}

TEST(Arena, NeverReleasesWhatIsLent) {
  const auto arena = make_arena();
  std::optional<ArenaScope> scope(arena);
  const Array<int> array(1000, 7);
  scope.reset();
  for (int i = 0; i < 3; ++i) arena->release_idle();
  arena->release_free();
  EXPECT_EQ(std::count(array.begin(), array.end(), 7), 1000);
  EXPECT_GE(arena->bytes(), array.bytes());
}

TEST(Arena, ReleaseFreeKeepsNothingElse) {
  const auto arena = make_arena();
  touch(arena, kMebibyte);
  arena->release_free();
  EXPECT_EQ(arena->bytes(), 0u);
}

TEST(Arena, ArraysMayOutliveIt) {
  auto arena = make_arena();
  Array<int> array;
  {
    const ArenaScope scope(arena);
    array = Array<int>(1000, 7);
  }
  arena.reset();
  EXPECT_EQ(std::count(array.begin(), array.end(), 7), 1000);
}

TEST(Arena, AScopeKeepsItAlive) {
  const ArenaScope scope(make_arena());
  const Array<int> array(1000, 7);
  EXPECT_EQ(std::count(array.begin(), array.end(), 7), 1000);
}

TEST(Arena, RefusesASizeThatRoundsUpToZero) {
  const auto arena = make_arena();
  EXPECT_THROW(arena->lend(std::size_t(-1)), std::bad_alloc);
  EXPECT_EQ(arena->bytes(), 0u);
}

TEST(ArenaScope, NestsAndEnds) {
  const auto outer = make_arena(), inner = make_arena();
  const Array<char> before(100);
  {
    const ArenaScope outer_scope(outer);
    {
      const ArenaScope inner_scope(inner);
      const Array<char> array(100);
      const ArenaScope none(nullptr);
      const Array<char> from_the_system(kMebibyte);
    }
    EXPECT_EQ(outer->bytes(), 0u);
    const Array<char> array(100);
  }
  const Array<char> after(100);
  EXPECT_EQ(inner->bytes(), 128u);
  EXPECT_EQ(outer->bytes(), 128u);
}

TEST(ArenaScope, IsOfItsThread) {
  const auto arena = make_arena();
  const ArenaScope scope(arena);
  std::thread([] { const Array<char> array(kMebibyte); }).join();
  EXPECT_EQ(arena->bytes(), 0u);
}

TEST(Arena, ManyThreadsLendAndReturn) {
  const auto arena = make_arena();
  std::vector<std::thread> threads;
  std::vector<int> wrong(4, 0);
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      const ArenaScope scope(arena);
      for (std::size_t i = 0; i < 500; ++i) {
        const Array<int> array(64 + 37 * (i % 11), t);
        wrong[std::size_t(t)] += std::count(array.begin(), array.end(), t) != int(array.size());
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, std::vector<int>(4, 0));
  arena->release_free();
  EXPECT_EQ(arena->bytes(), 0u);
}

TEST(Arena, ArraysMayEndOnOtherThreads) {
  const auto arena = make_arena();
  const test::ThreadCountScope threads(3);
  std::vector<Array<int>> arrays;
  {
    const ArenaScope scope(arena);
    for (int i = 0; i < 100; ++i) arrays.emplace_back(1000, i);
  }
  parallel_for(arrays.size(), 1, [&](std::size_t i) { arrays[i] = Array<int>(); });
  arena->release_free();
  EXPECT_EQ(arena->bytes(), 0u);
}

TEST(Arena, ArraysAndArenaMayEndAtOnce) {
  for (int round = 0; round < 200; ++round) {
    auto arena = make_arena();
    Array<int> array;
    {
      const ArenaScope scope(arena);
      array = Array<int>(1000, round);
    }
    std::thread dropping([moved = std::move(array)]() mutable { moved = Array<int>(); });
    arena.reset();
    dropping.join();
  }
}

#if defined(__SANITIZE_ADDRESS__)
TEST(ArenaDeathTest, TheAddressSanitizerSeesWhoTouchesFreedBytes) {
  const auto arena = make_arena();
  const char* const dropped = touch(arena, 1000);
  EXPECT_DEATH(std::printf("%c", *dropped), "use-after-poison");
  const ArenaScope scope(arena);
  const Array<char> shorter(900);
  EXPECT_DEATH(std::printf("%c", shorter.data()[904]), "use-after-poison");
}
#endif

}  // namespace
}  // namespace treelet
