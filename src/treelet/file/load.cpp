#include <treelet/file/load.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <string>
#include <utility>

#include <treelet/core/xxh64.h>
#include <treelet/file/facts.h>
#include <treelet/file/file_bytes.h>
#include <treelet/file/file_format.h>
#include <treelet/layout/check_structure.h>

namespace treelet {
namespace {

using namespace file_format;
using Bytes = std::span<const std::byte>;

constexpr const char* kAdvice = ": copy the file again, or build the tree again and save it";

std::string bytes_from_to(std::size_t begin, std::size_t end) {
  return "bytes " + std::to_string(begin) + " to " + std::to_string(end);
}

constexpr const char* kSectionNames[kSections] = {"facts", "nodes", "triangles"};

/// Takes a file apart, front to back; nothing is used before it has been checked.
class Loader {
 public:
  Loader(FileBytes file, bool verify) : file_(std::move(file)), verify_(verify) {}

  FileInfo read_info() {
    read_header();
    Bvh bvh;
    make_layout(bvh);
    constexpr std::string_view kNames[] = {"bvh2", "bvh8", "cwbvh"};
    return {header_.version, kNames[bvh.layout.index()], header_.file_bytes, header_.mesh_hash};
  }

  Bvh run() {
    read_header();
    check_sections();
    Bvh bvh;
    make_layout(bvh);
    std::visit([&](auto& layout) { fill(layout, bvh); }, bvh.layout);
    return bvh;
  }

 private:
  void read_header() {
    if constexpr (std::endian::native != std::endian::little) {
      throw FileError("the file is little-endian and this machine big-endian: build the tree here");
    }
    const std::size_t there = std::min(file_.bytes.size(), sizeof(Header));
    if (there > 0) std::memcpy(&header_, file_.bytes.data(), there);
    check_kind(there);
    if (there < sizeof(Header)) throw_cut_off("at least " + std::to_string(sizeof(Header)));
    if (header_.checksum != xxh64(file_.bytes.first(offsetof(Header, checksum)))) {
      throw FileError("the header, " + bytes_from_to(0, sizeof(Header)) + ", is damaged" + kAdvice);
    }
    if (header_.file_bytes > file_.bytes.size()) throw_cut_off(std::to_string(header_.file_bytes));
    if (header_.file_bytes < file_.bytes.size()) {
      throw FileError(bytes_from_to(header_.file_bytes, file_.bytes.size()) +
                      " do not belong to the tree" + kAdvice);
    }
  }

  /// Whether the bytes are a tree's, as far as they go, and of a version that is known here.
  void check_kind(std::size_t there) const {
    const std::size_t magic_bytes = std::min(there, kMagic.size());
    if (std::memcmp(&header_, kMagic.data(), magic_bytes) != 0) {
      throw FileError("the file holds no treelet tree: meshes are read by load_mesh()");
    }
    if (there < offsetof(Header, file_bytes))
      throw_cut_off("at least " + std::to_string(sizeof(Header)));
    if (header_.byte_order == kForeignByteOrder) {
      throw FileError(
          "the file is big-endian, and trees are read from little-endian files alone: build the "
          "tree "
          "again and save it on a little-endian machine");
    }
    if (header_.byte_order != kByteOrder) {
      throw FileError("the header, " + bytes_from_to(0, sizeof(Header)) + ", is damaged" + kAdvice);
    }
    if (header_.version != kVersion) throw_unknown_version();
  }

  [[noreturn]] void throw_unknown_version() const {
    const bool is_newer = header_.version > kVersion;
    throw FileError(
        "the file has format version " + std::to_string(header_.version) +
        ", this treelet reads version " + std::to_string(kVersion) + ": " +
        (is_newer ? "update treelet, or build the tree again" : "build the tree again"));
  }

  [[noreturn]] void throw_cut_off(const std::string& expected) const {
    throw FileError("the file is cut off: it has " + std::to_string(file_.bytes.size()) +
                    " bytes of " + expected + kAdvice);
  }

  /// Sections follow each other, with zeros between them, and fill the file.
  void check_sections() const {
    std::size_t end = sizeof(Header);
    for (std::uint32_t kind = 0; kind < kSections; ++kind) {
      const Section& section = header_.sections[kind];
      const std::size_t begin = align(end);
      const bool fits = section.kind == kind && section.offset == begin &&
                        begin <= file_.bytes.size() &&
                        section.bytes <= file_.bytes.size() - begin && section.item_bytes > 0 &&
                        section.bytes % section.item_bytes == 0;
      if (!fits) throw FileError("the table of sections makes no sense" + std::string(kAdvice));
      check_padding(end, begin);
      if (kind == kFacts || verify_) check_checksum(kind);
      end = begin + section.bytes;
    }
    if (align(end) != file_.bytes.size() || header_.section_count != kSections) {
      throw FileError("the sections do not fill the file" + std::string(kAdvice));
    }
    check_padding(end, file_.bytes.size());
  }

  void check_padding(std::size_t begin, std::size_t end) const {
    const Bytes padding = file_.bytes.subspan(begin, end - begin);
    if (std::any_of(padding.begin(), padding.end(), [](std::byte b) { return b != std::byte{}; })) {
      throw FileError("the padding, " + bytes_from_to(begin, end) + ", is damaged" + kAdvice);
    }
  }

  void check_checksum(std::uint32_t kind) const {
    const Section& section = header_.sections[kind];
    if (section.checksum == xxh64(bytes_of(kind))) return;
    throw FileError("the " + std::string(kSectionNames[kind]) + ", " +
                    bytes_from_to(section.offset, section.offset + section.bytes) +
                    ", are damaged" + kAdvice);
  }

  Bytes bytes_of(std::uint32_t kind) const {
    const Section& section = header_.sections[kind];
    return file_.bytes.subspan(section.offset, section.bytes);
  }

  void make_layout(Bvh& bvh) const {
    switch (header_.layout) {
      case kLayoutNumber<Bvh2>:
        bvh.layout = Bvh2();
        return;
      case kLayoutNumber<Bvh8>:
        bvh.layout = Bvh8();
        return;
      case kLayoutNumber<Cwbvh>:
        bvh.layout = Cwbvh();
        return;
      default:
        throw FileError("the file has a layout of an unknown kind, " +
                        std::to_string(header_.layout) + ": update treelet");
    }
  }

  template <class Layout>
  void fill(Layout& layout, Bvh& bvh) const {
    borrow(kNodes, layout.nodes);
    borrow(kTriangles, triangles_of(layout));
    read_facts(bvh);
    bvh.report.tree.nodes = layout.nodes.size();
    bvh.report.tree.bytes = layout.bytes();
    bvh.report.tree.depth = layout.depth;
    const std::string unsafe = find_unsafe_part(layout, bvh.report.faces);
    if (!unsafe.empty()) throw FileError("the tree is broken: " + unsafe + kAdvice);
  }

  /// Their checksum was right, so that what is wrong was written so.
  void read_facts(Bvh& bvh) const {
    try {
      ByteReader facts(bytes_of(kFacts));
      take_facts(facts, bvh);
    } catch (const FileError& error) {
      throw FileError("the facts are damaged or another version's, " + std::string(error.what()) +
                      kAdvice);
    }
  }

  template <class T>
  void borrow(std::uint32_t kind, Array<T>& array) const {
    const Section& section = header_.sections[kind];
    if (section.item_bytes != sizeof(T)) {
      throw FileError("the " + std::string(kSectionNames[kind]) + " have " +
                      std::to_string(section.item_bytes) + " bytes each, not " +
                      std::to_string(sizeof(T)) + kAdvice);
    }
    const Bytes bytes = bytes_of(kind);
    if (bytes.empty()) return;
    array = Array<T>::borrow({reinterpret_cast<const T*>(bytes.data()), bytes.size() / sizeof(T)},
                             file_.owner);
  }

  FileBytes file_;
  const bool verify_;
  Header header_{};
};

/// Lets errors begin with the file's name.
template <class Read>
auto name_file(const std::filesystem::path& path, Read&& read) {
  try {
    return read();
  } catch (const FileError& error) {
    throw FileError(path.string() + ": " + error.what());
  }
}

}  // namespace

FileInfo read_info(const std::filesystem::path& path) {
  return name_file(path, [&] { return Loader(map_file(path), false).read_info(); });
}

Bvh load(const std::filesystem::path& path, const LoadOptions& options) {
  return name_file(path, [&] {
    return Loader(options.map ? map_file(path) : read_file(path), options.verify).run();
  });
}

Bvh from_bytes(std::span<const std::byte> bytes) { return Loader(copy_bytes(bytes), true).run(); }

}  // namespace treelet
