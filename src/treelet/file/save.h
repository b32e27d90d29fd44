#pragma once

#include <filesystem>

#include <treelet/core/array.h>
#include <treelet/pipeline/bvh.h>

namespace treelet {

/// Writes a tree to a file (docs/file-format.md), whose usual ending is .treelet. The file is there
/// as a whole or not at all, and replaces one of this name. A tree that can be updated is saved as
/// it is now, and loads as one that cannot. Throws std::system_error.
void save(const Bvh& bvh, const std::filesystem::path& path);

/// The bytes of such a file.
Array<std::byte> to_bytes(const Bvh& bvh);

}  // namespace treelet
