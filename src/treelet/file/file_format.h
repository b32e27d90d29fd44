#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <treelet/layout/bvh2.h>
#include <treelet/layout/bvh8.h>
#include <treelet/layout/cwbvh.h>

// A tree in a file (docs/file-format.md): a header, and sections that begin on cache lines. All
// numbers are little-endian; nodes and triangles lie as in memory, so that a mapped file can be
// walked as it is.

namespace treelet::file_format {

inline constexpr std::uint32_t kVersion = 1;
/// As in PNG files: the first byte shows that the file went through nothing meant for text.
inline constexpr std::array<unsigned char, 8> kMagic = {0x89, 't', 'r', 'e', 'e', 'l', 'e', 't'};
inline constexpr std::uint32_t kByteOrder = 0x01020304, kForeignByteOrder = 0x04030201;
inline constexpr std::size_t kAlignment = 64;

enum SectionKind : std::uint32_t { kFacts, kNodes, kTriangles, kSections };

struct Section {
  std::uint32_t kind;
  std::uint32_t item_bytes;  ///< of a node or triangle; 1 for facts
  std::uint64_t offset, bytes;
  std::uint64_t checksum;  ///< xxh64
};
static_assert(sizeof(Section) == 32);

struct Header {
  std::array<unsigned char, 8> magic;
  std::uint32_t byte_order;
  std::uint32_t version;
  std::uint64_t file_bytes;
  std::uint32_t layout;
  std::uint32_t section_count;
  std::uint64_t mesh_hash;
  std::array<std::uint64_t, 3> reserved;  ///< zero
  std::array<Section, kSections> sections;
  std::uint64_t checksum;  ///< xxh64 of all before
};
static_assert(sizeof(Header) == 168);

constexpr std::size_t align(std::size_t bytes) {
  return (bytes + kAlignment - 1) / kAlignment * kAlignment;
}

template <class Layout>
inline constexpr std::uint32_t kLayoutNumber = 0;
template <>
inline constexpr std::uint32_t kLayoutNumber<Bvh2> = 1;
template <>
inline constexpr std::uint32_t kLayoutNumber<Bvh8> = 2;
template <>
inline constexpr std::uint32_t kLayoutNumber<Cwbvh> = 3;

/// What a layout keeps its triangles in.
template <class Layout>
auto& triangles_of(Layout& layout) {
  if constexpr (requires { layout.blocks; }) {
    return layout.blocks;
  } else {
    return layout.triangles;
  }
}

}  // namespace treelet::file_format
