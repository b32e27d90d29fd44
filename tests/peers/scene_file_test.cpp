#include "peers/scene_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <string>

namespace treelet::peers {
namespace {

std::string saved_bytes() {
  std::ifstream file(TREELET_SAVED_SCENE, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// A file of these bytes, while this lives.
class ScratchFile {
 public:
  explicit ScratchFile(const std::string& bytes)
      : path_(std::filesystem::path(testing::TempDir()) /
              ::testing::UnitTest::GetInstance()->current_test_info()->name()) {
    std::ofstream(path_, std::ios::binary) << bytes;
  }
  ~ScratchFile() { std::filesystem::remove(path_); }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

TEST(SceneFile, HoldsWhatPythonWrote) {
  const SceneFile scene = read_scene_file(TREELET_SAVED_SCENE);
  ASSERT_EQ(scene.vertices.size(), 4u);
  EXPECT_EQ(scene.vertices[2], (Vec3{1, 1, 0}));
  ASSERT_EQ(scene.faces.size(), 2u);
  EXPECT_EQ(scene.faces[1], (Face{0, 2, 3}));

  ASSERT_EQ(scene.ray_sets.size(), 2u);
  const RaySet& primary = scene.ray_sets[0];
  EXPECT_EQ(primary.kind, "primary");
  EXPECT_FALSE(primary.any_hit);
  const RayBatch rays = primary.batch();
  ASSERT_EQ(rays.size, 3u);
  EXPECT_EQ(rays[1].origin, (Vec3{0.125f, 0.25f, 1}));
  EXPECT_EQ(rays[1].direction, (Vec3{0, 0, -1}));
  EXPECT_EQ(rays[1].t_min, 0.0f);
  EXPECT_EQ(rays[1].t_max, std::numeric_limits<float>::infinity());

  const RaySet& occlusion = scene.ray_sets[1];
  EXPECT_EQ(occlusion.kind, "ambient_occlusion");
  EXPECT_TRUE(occlusion.any_hit);
  ASSERT_EQ(occlusion.batch().size, 2u);
  EXPECT_EQ(occlusion.batch()[1].t_max, 0.5f);
}

TEST(SceneFile, LeavesRoomForEmbreeToReadBehindTheVertices) {
  const SceneFile scene = read_scene_file(TREELET_SAVED_SCENE);
  EXPECT_GT(scene.vertices.capacity(), scene.vertices.size());
}

TEST(SceneFile, RefusesAFileThatEndsEarly) {
  const std::string bytes = saved_bytes();
  for (std::size_t length = 0; length < bytes.size(); length += 3) {
    const ScratchFile file(bytes.substr(0, length));
    EXPECT_THROW(read_scene_file(file.path()), std::runtime_error) << length;
  }
}

TEST(SceneFile, RefusesAHugeCountWithoutTakingMemory) {
  std::string bytes = saved_bytes();
  bytes[16 + 7] = 0x7f;  // the highest byte of the number of vertices
  const ScratchFile file(bytes);
  EXPECT_THROW(read_scene_file(file.path()), std::runtime_error);
}

TEST(SceneFile, RefusesABadIndexAndAMissingFile) {
  std::string bytes = saved_bytes();
  bytes[16 + 24 + 4 * 12] = 9;  // a corner of the first face
  const ScratchFile file(bytes);
  EXPECT_THROW(read_scene_file(file.path()), std::invalid_argument);
  EXPECT_THROW(read_scene_file("no/such/file"), std::runtime_error);
}

}  // namespace
}  // namespace treelet::peers
