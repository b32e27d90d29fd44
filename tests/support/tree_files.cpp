#include "support/tree_files.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <iterator>
#include <random>

#include <treelet/core/xxh64.h>
#include <treelet/file/file_format.h>
#include <treelet/file/load.h>
#include <treelet/file/save.h>
#include <treelet/pipeline/build.h>

#include "support/mesh_rays.h"

namespace treelet::test {

using namespace file_format;

const char* const kFileRecipes[4] = {"lbvh > treelet > bvh2", "lbvh > bvh8", "hploc > cwbvh",
                                     "presplit(budget=100) > lbvh > bvh8"};

Bvh small_tree(const char* recipe, std::size_t triangles) {
  return build(soup_with_bad_faces(triangles, 7).view(), recipe);
}

Bytes bytes_of(const Bvh& bvh) {
  const Array<std::byte> bytes = to_bytes(bvh);
  return {bytes.begin(), bytes.end()};
}

void reseal(Bytes& bytes) {
  Header header;
  std::memcpy(&header, bytes.data(), sizeof(Header));
  for (Section& section : header.sections) {
    if (section.offset > bytes.size() || section.bytes > bytes.size() - section.offset) continue;
    section.checksum = xxh64(std::span(bytes).subspan(section.offset, section.bytes));
  }
  std::memcpy(bytes.data(), &header, sizeof(Header));
  header.checksum = xxh64(std::span(bytes).first(offsetof(Header, checksum)));
  std::memcpy(bytes.data(), &header, sizeof(Header));
}

void use(const Bvh& bvh) {
  static const std::vector<Ray> rays = rays_at(triangle_soup(20, 3).view(), 4, 5);
  const std::vector<Hit> hits = bvh.intersect(rays);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (hits[i].is_hit()) (void)bvh.is_occluded(rays[i]);
    (void)bvh.intersect(rays[i]);
    (void)bvh.intersect_all(rays[i]);
    (void)bvh.count_hits(rays[i]);
    (void)bvh.closest_point(rays[i].origin);
  }
  const std::vector<Vec3> points{rays[0].origin, {0.5f, 0.5f, 0.5f}, {0, 0, 0}};
  Array<float> numbers(points.size());
  bvh.winding_number(std::span(points), 2.0f, numbers);
  bvh.signed_distance(std::span(points), numbers);
  (void)bvh.validate();
  (void)bvh.epo(10);
}

std::string load_and_use(const Bytes& bytes) {
  try {
    use(from_bytes(bytes));
    return {};
  } catch (const FileError& error) {
    return error.what();
  }
}

TemporaryFolder::TemporaryFolder() {
  std::random_device random;
  path_ = std::filesystem::temp_directory_path() / ("treelet-" + std::to_string(random()));
  std::filesystem::create_directories(path_);
}
TemporaryFolder::~TemporaryFolder() { std::filesystem::remove_all(path_); }

Bytes read(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

void write(const std::filesystem::path& path, const Bytes& bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
}

}  // namespace treelet::test
