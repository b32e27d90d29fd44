#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>

#include <treelet/file/file_error.h>
#include <treelet/pipeline/bvh.h>

namespace treelet {

/// How to load a tree. Whatever these say, a tree is given back only if its header and facts are
/// undamaged and walking it is safe: no bytes can crash a query (layout/check_structure.h).
struct LoadOptions {
  /// Walk the file's own pages, which all processes share, instead of a copy. The file must not be
  /// changed in place while the tree lives; to replace it is fine, and all that save() does.
  bool map = true;
  /// Compare the checksums of nodes and triangles too: finds any damage. Reads the whole file.
  bool verify = false;
};

/// What the header of a file says.
struct FileInfo {
  std::uint32_t version;
  std::string_view layout;  ///< as in recipes: "bvh2", "bvh8", "cwbvh"
  std::uint64_t bytes;
  std::uint64_t mesh_hash;  ///< of the mesh that the tree was built over (layout/mesh_hash.h)
};

/// Reads the header alone. Throws as load().
FileInfo read_info(const std::filesystem::path& path);

/// Loads a tree that save() wrote. Throws FileError for a file that is foreign, damaged, cut off or
/// newer than this library, std::system_error where it cannot be read.
Bvh load(const std::filesystem::path& path, const LoadOptions& options = {});

/// From the bytes of such a file, which are copied and verified.
Bvh from_bytes(std::span<const std::byte> bytes);

}  // namespace treelet
