#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>

namespace treelet {

/// The bytes of a file, and what keeps them alive.
struct FileBytes {
  std::span<const std::byte> bytes;
  std::shared_ptr<const void> owner;
};

/// Maps a file, read only: its pages are read when they are touched and shared by all processes
/// that map it. Where files cannot be mapped, reads it. Throws std::system_error.
FileBytes map_file(const std::filesystem::path& path);

/// Reads a file into memory that begins on a cache line, on huge pages where it is large. Throws
/// std::system_error.
FileBytes read_file(const std::filesystem::path& path);

/// A copy in memory of that kind.
FileBytes copy_bytes(std::span<const std::byte> bytes);

/// Writes a file that is there as a whole or not at all: the spans, one after the other, to another
/// name in the same folder, which then takes the place of `path`. Who has the old file mapped keeps
/// it. Throws std::system_error.
void replace_file(const std::filesystem::path& path,
                  std::span<const std::span<const std::byte>> parts);

}  // namespace treelet
