#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include <treelet/pipeline/bvh.h>

#include "support/meshes.h"

namespace treelet::test {

using Bytes = std::vector<std::byte>;

/// A recipe for each layout, and one that splits triangles.
extern const char* const kFileRecipes[4];

/// A small mesh of which some triangles are left out, built by a recipe.
Bvh small_tree(const char* recipe, std::size_t triangles = 60);

/// What save() writes of a tree.
Bytes bytes_of(const Bvh& bvh);

/// Makes checksums of the header and of all sections right again, as far as the sections lie in the
/// file: what somebody does who wants a broken tree to be loaded.
void reseal(Bytes& bytes);

/// Uses a tree in all ways: its answers mean nothing, but it must not crash.
void use(const Bvh& bvh);

/// The message of the FileError that from_bytes() throws; empty where the tree was loaded, and then
/// used.
std::string load_and_use(const Bytes& bytes);

/// A folder that is removed with all that is in it.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

Bytes read(const std::filesystem::path& path);
void write(const std::filesystem::path& path, const Bytes& bytes);

}  // namespace treelet::test
