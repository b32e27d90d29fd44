#include <treelet/file/save.h>

#include <algorithm>
#include <bit>
#include <vector>

#include <treelet/core/xxh64.h>
#include <treelet/file/facts.h>
#include <treelet/file/file_bytes.h>
#include <treelet/file/file_error.h>
#include <treelet/file/file_format.h>
#include <treelet/layout/mesh_hash.h>

namespace treelet {
namespace {

using namespace file_format;
using Bytes = std::span<const std::byte>;

constexpr std::byte kPadding[kAlignment] = {};

/// The spans that make up the file, in order; the tree's own memory where that can be.
class FileImage {
 public:
  explicit FileImage(const Bvh& bvh) {
    if constexpr (std::endian::native != std::endian::little) {
      throw FileError("this machine is big-endian, and a file is little-endian: save it elsewhere");
    }
    put_facts(bvh, facts_);
    add(Bytes(reinterpret_cast<const std::byte*>(&header_), sizeof(Header)));
    std::visit([&](const auto& layout) { add_sections(layout, bvh); }, bvh.layout);
    header_.file_bytes = size_;
    header_.checksum = xxh64(parts_[0].first(offsetof(Header, checksum)));
  }
  FileImage(const FileImage&) = delete;
  FileImage& operator=(const FileImage&) = delete;

  std::size_t size() const { return size_; }
  std::span<const Bytes> parts() const { return parts_; }

 private:
  template <class Layout>
  void add_sections(const Layout& layout, const Bvh& bvh) {
    header_.magic = kMagic;
    header_.byte_order = kByteOrder;
    header_.version = kVersion;
    header_.layout = kLayoutNumber<Layout>;
    header_.section_count = kSections;
    header_.mesh_hash = hash_mesh(layout, bvh.report.faces, bvh.placement.offset);
    add_section(kFacts, facts_.bytes());
    add_section(kNodes, std::span(layout.nodes.data(), layout.nodes.size()));
    add_section(kTriangles, std::span(triangles_of(layout).data(), triangles_of(layout).size()));
  }

  template <class T>
  void add_section(SectionKind kind, std::span<const T> items) {
    const Bytes bytes = std::as_bytes(items);
    header_.sections[kind] = {kind, sizeof(T), size_, bytes.size(), xxh64(bytes)};
    add(bytes);
  }

  void add(Bytes bytes) {
    parts_.push_back(bytes);
    const std::size_t padding = align(bytes.size()) - bytes.size();
    parts_.push_back(Bytes(kPadding, padding));
    size_ += bytes.size() + padding;
  }

  Header header_{};
  ByteWriter facts_;
  std::vector<Bytes> parts_;
  std::size_t size_ = 0;
};

}  // namespace

void save(const Bvh& bvh, const std::filesystem::path& path) {
  replace_file(path, FileImage(bvh).parts());
}

Array<std::byte> to_bytes(const Bvh& bvh) {
  const FileImage image(bvh);
  Array<std::byte> bytes(image.size());
  std::byte* end = bytes.begin();
  for (const Bytes part : image.parts()) end = std::copy(part.begin(), part.end(), end);
  return bytes;
}

}  // namespace treelet
