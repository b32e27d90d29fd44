#include <treelet/core/xxh64.h>

#include <gtest/gtest.h>

#include <string_view>
#include <vector>

namespace treelet {
namespace {

std::uint64_t hash_text(std::string_view text, std::uint64_t seed = 0) {
  return xxh64(std::as_bytes(std::span(text)), seed);
}

// Expected values are those of the Python package xxhash.
TEST(Xxh64, HashesAsTheReferenceDoes) {
  EXPECT_EQ(hash_text(""), 0xef46db3751d8e999u);
  EXPECT_EQ(hash_text("a"), 0xd24ec4f1a98c6e5bu);
  EXPECT_EQ(hash_text("abc"), 0x44bc2cf5ad770999u);
  EXPECT_EQ(hash_text("Nobody inspects the spammish repetition"), 0xfbcea83c8a378bf1u);
}

TEST(Xxh64, FindsEveryChangedByteAndEveryCut) {
  std::vector<std::byte> bytes(100);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = std::byte(i * 37);
  const std::uint64_t hash = xxh64(bytes);
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    for (int change = 1; change < 256; ++change) {
      bytes[i] ^= std::byte(change);
      ASSERT_NE(xxh64(bytes), hash) << "byte " << i << " changed by " << change;
      bytes[i] ^= std::byte(change);
    }
    ASSERT_NE(xxh64(std::span(bytes).first(i)), hash);
  }
}

}  // namespace
}  // namespace treelet
