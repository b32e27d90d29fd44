// Files made to break what loads or walks them: every checksum is right.

#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <cstring>
#include <string>

#include <treelet/file/file_format.h>
#include <treelet/file/load.h>

#include "support/random.h"
#include "support/tree_files.h"

namespace treelet::test {
namespace {

using namespace file_format;

/// Seconds more, for `TREELET_FUZZ_SECONDS=3600 treelet_file_tests --gtest_filter=Hostile*`.
double fuzz_seconds() {
  const char* const seconds = std::getenv("TREELET_FUZZ_SECONDS");
  return seconds == nullptr ? 0.0 : std::atof(seconds);
}

/// Loads a sealed file: whether it was loaded. Then it was used, too.
bool try_sealed(Bytes& bytes) {
  reseal(bytes);
  return load_and_use(bytes).empty();
}

std::uint32_t nasty_word(Random& random) {
  constexpr std::uint32_t kWords[] = {0u,          1u,          2u,          7u,
                                      0x7fffffffu, 0x80000000u, 0x80000001u, 0xe0000000u,
                                      0xffffffffu, 0x7fc00000u, 0x7f800000u, 0xff800000u,
                                      0x7f7fffffu, 0x00000001u, 0x20000000u, 0xfffffffeu};
  constexpr std::size_t kCount = sizeof(kWords) / sizeof(kWords[0]);
  const std::uint64_t choice = random.below(kCount + 3);
  return choice < kCount ? kWords[choice] : std::uint32_t(random.below(40));
}

void damage(Bytes& bytes, Random& random) {
  const std::size_t at = random.below(bytes.size());
  if (random.below(3) == 0) {
    bytes[at] ^= std::byte(1u << random.below(8));
  } else if (const std::size_t word = at / 4 * 4; word + 4 <= bytes.size()) {
    const std::uint32_t value = nasty_word(random);
    std::memcpy(&bytes[word], &value, sizeof(value));
  }
}

TEST(Hostile, NoByteCrashesTheReader) {
  for (const char* recipe : kFileRecipes) {
    const Bytes bytes = bytes_of(small_tree(recipe, 12));
    std::size_t loaded = 0;
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      Bytes damaged = bytes;
      damaged[i] ^= std::byte(i % 2 == 0 ? 0xff : 0x01);
      loaded += try_sealed(damaged);
    }
    EXPECT_GT(loaded, 0u) << "nothing got as far as being used";
    EXPECT_LT(loaded, bytes.size());
  }
}

TEST(Hostile, NoDamageCrashesTheReader) {
  const auto start = std::chrono::steady_clock::now();
  const auto is_time_left = [&] {
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    return elapsed.count() < fuzz_seconds();
  };
  std::size_t files = 0, loaded = 0;
  std::uint64_t seed = 1;
  for (; seed <= 3 || is_time_left(); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    for (const char* recipe : kFileRecipes) {
      const Bytes bytes = bytes_of(small_tree(recipe, 5 + random.below(60)));
      for (int round = 0; round < 400; ++round, ++files) {
        Bytes damaged = bytes;
        for (std::uint64_t n = 1 + random.below(4); n-- > 0;) damage(damaged, random);
        loaded += try_sealed(damaged);
      }
    }
  }
  EXPECT_GT(loaded, 0u);
  RecordProperty("files", std::to_string(files));
}

TEST(Hostile, NeitherRandomBytesNorCutsCrashTheReader) {
  Random random(5);
  for (const char* recipe : kFileRecipes) {
    const Bytes bytes = bytes_of(small_tree(recipe, 12));
    for (std::size_t size = sizeof(Header); size < bytes.size(); size += 3) {
      Bytes cut(bytes.begin(), bytes.begin() + std::ptrdiff_t(size));
      EXPECT_FALSE(try_sealed(cut));
      Header header;
      std::memcpy(&header, cut.data(), sizeof(Header));
      header.file_bytes = size;
      std::memcpy(cut.data(), &header, sizeof(Header));
      EXPECT_FALSE(try_sealed(cut));
      for (std::size_t i = sizeof(Header); i < size; ++i) cut[i] = std::byte(random.bits());
      EXPECT_FALSE(try_sealed(cut));
    }
  }
}

}  // namespace
}  // namespace treelet::test
