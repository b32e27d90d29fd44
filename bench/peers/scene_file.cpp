#include "peers/scene_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <fstream>
#include <stdexcept>
#include <string_view>

namespace treelet::peers {
namespace {

static_assert(std::endian::native == std::endian::little, "scene files are little-endian");

constexpr std::string_view kMagic = "treelet peers 1\n";
constexpr std::size_t kKindBytes = 24;

class Reader {
 public:
  explicit Reader(const std::filesystem::path& path)
      : path_(path), file_(path, std::ios::binary), left_(file_ ? file_size(path) : 0) {
    if (!file_) fail("cannot be opened");
  }

  [[noreturn]] void fail(const std::string& why) const {
    throw std::runtime_error(path_.string() + ": " + why);
  }

  std::uint64_t read_number() {
    std::uint64_t number;
    read_bytes(&number, sizeof(number));
    return number;
  }

  std::string read_text(std::size_t bytes) {
    std::string text(bytes, '\0');
    read_bytes(text.data(), bytes);
    text.resize(std::min(text.size(), text.find('\0')));
    return text;
  }

  template <class T>
  std::vector<T> read_array(std::uint64_t count) {
    if (count > left_ / sizeof(T)) fail("ends too early");
    std::vector<T> values;
    values.reserve(count + 1);  // Embree reads vertices sixteen bytes at a time
    values.resize(count);
    read_bytes(values.data(), count * sizeof(T));
    return values;
  }

 private:
  void read_bytes(void* to, std::size_t bytes) {
    if (bytes > left_) fail("ends too early");
    left_ -= bytes;
    if (!file_.read(static_cast<char*>(to), std::streamsize(bytes))) fail("cannot be read");
  }

  std::filesystem::path path_;
  std::ifstream file_;
  std::uint64_t left_;
};

RaySet read_ray_set(Reader& reader) {
  RaySet set;
  set.kind = reader.read_text(kKindBytes);
  set.any_hit = reader.read_number() != 0;
  const std::uint64_t rays = reader.read_number();
  set.origins = reader.read_array<Vec3>(rays);
  set.directions = reader.read_array<Vec3>(rays);
  set.t_max = reader.read_array<float>(rays);
  return set;
}

}  // namespace

RayBatch RaySet::batch() const {
  RayBatch batch;
  batch.size = origins.size();
  batch.origins = {origins.data(), sizeof(Vec3)};
  batch.directions = {directions.data(), sizeof(Vec3)};
  batch.t_max = {t_max.data(), sizeof(float)};
  return batch;
}

SceneFile read_scene_file(const std::filesystem::path& path) {
  Reader reader(path);
  if (reader.read_text(kMagic.size()) != kMagic) reader.fail("is no scene file of the peers");
  const std::uint64_t vertices = reader.read_number();
  const std::uint64_t faces = reader.read_number();
  const std::uint64_t ray_sets = reader.read_number();
  SceneFile scene;
  scene.vertices = reader.read_array<Vec3>(vertices);
  scene.faces = reader.read_array<Face>(faces);
  for (std::uint64_t i = 0; i < ray_sets; ++i) scene.ray_sets.push_back(read_ray_set(reader));
  check_indices(scene.mesh());
  return scene;
}

}  // namespace treelet::peers
