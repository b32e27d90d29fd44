#include <treelet/file/load.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <system_error>

#include <treelet/file/file_format.h>

#include "support/errors.h"
#include "support/tree_files.h"

namespace treelet::test {
namespace {

using namespace file_format;

std::string error_of_file(const Bytes& bytes, const LoadOptions& options = {}) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder / "a.treelet";
  write(path, bytes);
  const std::string message = error_of<FileError>([&] { load(path, options); });
  EXPECT_EQ(message.find(path.string() + ": "), 0u) << message;
  return message.substr(std::min(message.size(), path.string().size() + 2));
}

bool begins_with(const std::string& text, const std::string& with) { return text.find(with) == 0; }

template <class Change>
Bytes changed(Bytes bytes, Change&& change) {
  Header header;
  std::memcpy(&header, bytes.data(), sizeof(Header));
  change(header);
  std::memcpy(bytes.data(), &header, sizeof(Header));
  return bytes;
}

TEST(Load, ReadsTheHeaderAlone) {
  const TemporaryFolder folder;
  const char* const kLayouts[] = {"bvh2", "bvh8", "cwbvh", "bvh8"};
  for (int i = 0; i < 4; ++i) {
    const Bytes bytes = bytes_of(small_tree(kFileRecipes[i]));
    write(folder / "a.treelet", bytes);
    const FileInfo info = read_info(folder / "a.treelet");
    EXPECT_EQ(info.version, kVersion);
    EXPECT_EQ(info.layout, kLayouts[i]);
    EXPECT_EQ(info.bytes, bytes.size());
  }
}

TEST(Load, NamesWhatIsNoTree) {
  const std::string message = "the file holds no treelet tree: meshes are read by load_mesh()";
  const std::string text = "ply\nformat ascii 1.0\n";
  const auto view = std::as_bytes(std::span(text));
  EXPECT_EQ(error_of_file({view.begin(), view.end()}), message);
  EXPECT_EQ(error_of_file({std::byte{'p'}}), message);
  EXPECT_EQ(error_of_file(Bytes(1000)), message);
}

TEST(Load, NamesOtherVersionsAndMachines) {
  const Bytes bytes = bytes_of(small_tree("lbvh > bvh2"));
  const Bytes newer = changed(bytes, [](Header& header) { header.version = 7; });
  EXPECT_EQ(error_of_file(newer),
            "the file has format version 7, this treelet reads version 1: update treelet, or build "
            "the tree again");
  const Bytes older = changed(bytes, [](Header& header) { header.version = 0; });
  EXPECT_TRUE(begins_with(error_of_file(older), "the file has format version 0,"));
  const Bytes foreign = changed(bytes, [](Header& header) { header.byte_order = 0x04030201; });
  EXPECT_TRUE(begins_with(error_of_file(foreign), "the file is big-endian"));
  Bytes layout = changed(bytes, [](Header& header) { header.layout = 9; });
  reseal(layout);
  EXPECT_EQ(error_of_file(layout), "the file has a layout of an unknown kind, 9: update treelet");
}

TEST(Load, SaysWhatToDoAboutFactsThatCannotBe) {
  Bytes bytes = bytes_of(small_tree("lbvh > bvh2"));
  Header header;
  std::memcpy(&header, bytes.data(), sizeof(Header));
  constexpr std::size_t kOffset = 40,
                        kFaces = 80;  // behind bounds, depth and costs; behind seconds
  const auto error_with = [&](std::size_t at, auto value) {
    Bytes damaged = bytes;
    std::memcpy(&damaged[header.sections[kFacts].offset + at], &value, sizeof(value));
    reseal(damaged);
    return error_of_file(damaged);
  };
  const std::string start = "the facts are damaged or another version's, ";
  const std::string advice = ": copy the file again, or build the tree again and save it";
  EXPECT_EQ(error_with(kOffset, std::numeric_limits<double>::infinity()),
            start + "the offset is not finite" + advice);
  EXPECT_EQ(error_with(kFaces, std::uint64_t{1} << 40),
            start + "there are more faces than a mesh can have" + advice);
}

TEST(Load, NamesFilesThatAreMissingOrNoFiles) {
  const TemporaryFolder folder;
  for (const bool map : {true, false}) {
    try {
      load(folder / "missing.treelet", {.map = map});
      ADD_FAILURE();
    } catch (const std::system_error& error) {
      EXPECT_EQ(error.code(), std::errc::no_such_file_or_directory);
    }
    EXPECT_THROW(load(folder.path(), {.map = map}), std::system_error);
  }
}

TEST(Load, FindsEveryCut) {
  for (const char* recipe : {kFileRecipes[0], kFileRecipes[1], kFileRecipes[2]}) {
    const Bytes bytes = bytes_of(small_tree(recipe, 6));
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      const Bytes cut(bytes.begin(), bytes.begin() + std::ptrdiff_t(size));
      const std::string message = load_and_use(cut);
      ASSERT_TRUE(begins_with(message,
                              "the file is cut off: it has " + std::to_string(size) + " bytes of "))
          << message;
    }
    Bytes longer = bytes;
    longer.resize(bytes.size() + 64);
    EXPECT_FALSE(load_and_use(longer).empty());
  }
  EXPECT_TRUE(begins_with(error_of_file({}), "the file is cut off: it has 0 bytes of at least"));
}

TEST(Load, FindsEveryChangedByte) {
  for (const char* recipe : {kFileRecipes[0], kFileRecipes[1], kFileRecipes[2]}) {
    Bytes bytes = bytes_of(small_tree(recipe, 10));
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      for (const int change : {1, 0x80, 0xff}) {
        bytes[i] ^= std::byte(change);
        ASSERT_FALSE(load_and_use(bytes).empty()) << "byte " << i << " changed by " << change;
        bytes[i] ^= std::byte(change);
      }
    }
  }
}

TEST(Load, SaysWhereTheDamageIs) {
  Bytes bytes = bytes_of(small_tree("lbvh > bvh2"));
  Header header;
  std::memcpy(&header, bytes.data(), sizeof(Header));
  const auto error_at = [&](std::size_t offset) {
    Bytes damaged = bytes;
    damaged[offset] ^= std::byte{0x10};
    return error_of_file(damaged, {.verify = true});
  };
  EXPECT_TRUE(begins_with(error_at(60), "the header, bytes 0 to 168, is damaged: copy the file"));
  EXPECT_TRUE(begins_with(error_at(header.sections[kFacts].offset), "the facts, bytes 192 to "));
  const Section& nodes = header.sections[kNodes];
  EXPECT_TRUE(begins_with(error_at(nodes.offset + nodes.bytes / 2),
                          "the nodes, bytes " + std::to_string(nodes.offset) + " to "));
  const Section& triangles = header.sections[kTriangles];
  EXPECT_TRUE(begins_with(error_at(triangles.offset), "the triangles, bytes "));
  EXPECT_TRUE(begins_with(error_at(170), "the padding, bytes 168 to 192, is damaged"));
}

TEST(Load, ComparesTheChecksumsOfArraysOnlyWhereAsked) {
  Bytes bytes = bytes_of(small_tree("lbvh > bvh2"));
  Header header;
  std::memcpy(&header, bytes.data(), sizeof(Header));
  bytes[header.sections[kTriangles].offset] ^= std::byte{1};  // the last bit of a coordinate
  const TemporaryFolder folder;
  write(folder / "a.treelet", bytes);
  use(load(folder / "a.treelet"));
  EXPECT_THROW(load(folder / "a.treelet", {.verify = true}), FileError);
}

}  // namespace
}  // namespace treelet::test
