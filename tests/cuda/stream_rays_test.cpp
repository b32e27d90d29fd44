#include <treelet/query/stream_rays.h>

#include <gtest/gtest.h>

#include <treelet/pipeline/build.h>
#include <treelet/pipeline/device_bvh.h>

#include <algorithm>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "cuda/device_input.h"
#include "cuda/device_rays.h"
#include "support/errors.h"
#include "support/mesh_rays.h"
#include "support/meshes.h"

#if __has_include(<emulator/control.h>)
#include <emulator/control.h>
#endif

namespace treelet {
namespace {

using cuda::StreamOptions;

/// Some tree, and rays of every kind at it.
struct Scene {
  test::OwnedMesh mesh = test::triangle_soup(300, 8);
  Bvh host;
  cuda::DeviceBvh bvh;
  std::vector<Ray> rays = test::rays_at(mesh.view(), 60, 16);

  explicit Scene(const char* recipe = "lbvh > bvh8")
      : host(build(mesh.view(), recipe)), bvh(cuda::DeviceBvh::upload(host, test::kStream)) {}
};

test::Answers stream(const cuda::DeviceBvh& bvh, const RayBatch& rays,
                     const StreamOptions& options) {
  std::vector<float> t(rays.size), u(rays.size), v(rays.size);
  std::vector<std::int32_t> face(rays.size);
  const auto occluded = std::make_unique<bool[]>(rays.size);
  test::Answers answers;
  answers.nodes.resize(rays.size);
  answers.triangles.resize(rays.size);
  bvh.intersect(rays, {t.data(), face.data(), u.data(), v.data()}, options);
  bvh.find_occluded(rays, occluded.get(), options);
  bvh.count_work(rays, {answers.nodes.data(), answers.triangles.data()}, options);
  for (std::size_t i = 0; i < rays.size; ++i) answers.hits.push_back({t[i], face[i], u[i], v[i]});
  answers.occluded.assign(occluded.get(), occluded.get() + rays.size);
  return answers;
}

TEST(StreamRays, AnswersAsOneBatchWhateverTheChunks) {
  const Scene scene;
  const std::size_t count = scene.rays.size();
  const test::Answers expected =
      test::trace(scene.bvh, test::DeviceRays(scene.rays), RayOrder::given);
  EXPECT_EQ(expected.hits, scene.host.intersect(scene.rays));
  for (const RayOrder order : {RayOrder::given, RayOrder::coherent}) {
    for (const std::size_t bytes : {std::size_t{6000}, 40 * count, std::size_t{1} << 28}) {
      EXPECT_EQ(stream(scene.bvh, RayBatch(scene.rays), {order, bytes}), expected) << bytes;
    }
  }
  const std::span few(scene.rays.data(), 5);
  EXPECT_EQ(stream(scene.bvh, RayBatch(few), {RayOrder::given, 1}).hits, scene.host.intersect(few))
      << "a ray a chunk";
}

TEST(StreamRays, SendsOnceWhatAllRaysShare) {
  const Scene scene("lbvh > bvh2");
  const float t_max = 0.75f;
  RayBatch batch(scene.rays);
  batch.origins = {&scene.rays[3].origin, 0};
  batch.t_max = {&t_max, 0};
  const test::Answers answers = stream(scene.bvh, batch, {RayOrder::given, 8000});
  for (std::size_t i = 0; i < batch.size; ++i) {
    ASSERT_EQ(answers.hits[i], scene.host.intersect(batch[i])) << "ray " << i;
  }
}

TEST(StreamRays, ReadsDenseArraysInPlace) {
  const Scene scene;
  std::vector<Vec3> origins, directions;
  for (const Ray& ray : scene.rays) {
    origins.push_back(ray.origin);
    directions.push_back(ray.direction);
  }
  RayBatch batch;  // without limits
  batch.size = scene.rays.size();
  batch.origins = {origins.data(), sizeof(Vec3)};
  batch.directions = {directions.data(), sizeof(Vec3)};
  const test::Answers answers = stream(scene.bvh, batch, {RayOrder::coherent, 9000});
  for (std::size_t i = 0; i < batch.size; ++i) {
    ASSERT_EQ(answers.hits[i], scene.host.intersect(batch[i])) << "ray " << i;
  }
}

TEST(StreamRays, OfNothingWritesNothing) {
  const Scene scene;
  const test::Answers answers = stream(scene.bvh, RayBatch(), {});
  EXPECT_TRUE(answers.hits.empty());
}

TEST(StreamRays, FollowsATreeThatMoves) {
  const test::OwnedMesh mesh = test::triangle_soup(300, 8);
  const auto vertices = test::upload_all(std::span(mesh.vertices));
  const auto faces = test::upload_all(std::span(mesh.faces));
  const cuda::DeviceMesh view{vertices.data(), faces.data(), std::uint32_t(vertices.size()),
                              std::uint32_t(faces.size())};
  cuda::DeviceBvh bvh = cuda::DeviceBvh::build(
      view, parse_recipe("lbvh > bvh2"), {.validate = false, .updatable = true}, test::kStream);
  const test::OwnedMesh moved = test::translated(mesh, {0.5f, 0, 0});
  const auto moved_vertices = test::upload_all(std::span(moved.vertices));
  const std::vector<Ray> rays = test::rays_at(moved.view(), 30, 17);
  bvh.refit(moved_vertices.data(), std::uint32_t(moved_vertices.size()), test::kStream);
  const test::Answers answers = stream(bvh, RayBatch(rays), {RayOrder::given, 5000});
  EXPECT_EQ(answers.hits, build(moved.view(), "lbvh > bvh2").intersect(rays));
}

/// Answers each ray's own x; fails at the chunk that it is told to.
class EchoX {
 public:
  explicit EchoX(std::size_t bad_chunk) : bad_chunk_(bad_chunk) {}

  void operator()(const cuda::DeviceRayBatch& rays, std::span<void* const> answers,
                  cuda::Stream stream) {
    if (chunks_++ == bad_chunk_) throw std::runtime_error("a bad chunk");
    largest_ = std::max(largest_, rays.size);
    for (std::size_t i = 0; i < rays.size; ++i) {
      cuda::copy_on_device(static_cast<float*>(answers[0]) + i,
                           rays.origins.first + i * rays.origins.stride, sizeof(float), stream);
    }
  }
  std::size_t chunks() const { return chunks_; }
  std::size_t largest() const { return largest_; }

 private:
  std::size_t bad_chunk_, chunks_ = 0, largest_ = 0;
};

std::vector<Ray> numbered_rays(std::size_t count) {
  std::vector<Ray> rays(count);
  for (std::size_t i = 0; i < count; ++i) rays[i].origin.x = float(i);
  return rays;
}

TEST(StreamRays, CutsChunksByTheBytesThereAre) {
  const std::vector<Ray> rays = numbered_rays(1000);
  std::vector<float> answers(rays.size(), -1.0f);
  const cuda::AnswerArray array{answers.data(), sizeof(float)};
  EchoX echo(rays.size());
  const std::size_t ray_bytes = sizeof(Ray) + sizeof(float);
  cuda::stream_rays(RayBatch(rays), {&array, 1}, {RayOrder::given, 2 * 100 * ray_bytes},
                    std::ref(echo));
  EXPECT_EQ(echo.largest(), 100u);
  EXPECT_EQ(echo.chunks(), 10u);
  for (std::size_t i = 0; i < rays.size(); ++i) ASSERT_EQ(answers[i], float(i));
}

TEST(StreamRays, AfterAnErrorNothingIsUnderWay) {
  const std::vector<Ray> rays = numbered_rays(1000);
  std::vector<float> answers(rays.size(), -1.0f);
  const cuda::AnswerArray array{answers.data(), sizeof(float)};
#if __has_include(<emulator/control.h>)
  const std::size_t allocations = emulator::allocation_count();
#endif
  for (const std::size_t bad_chunk : {0, 1, 2, 5, 9}) {
    EchoX echo(bad_chunk);
    const auto run = [&] {
      cuda::stream_rays(RayBatch(rays), {&array, 1}, {RayOrder::given, 7200}, std::ref(echo));
    };
    EXPECT_EQ(test::error_of<std::runtime_error>(run), "a bad chunk");
    EXPECT_EQ(echo.chunks(), bad_chunk + 1);
  }
#if __has_include(<emulator/control.h>)
  EXPECT_EQ(emulator::allocation_count(), allocations);
#endif
}

#if __has_include(<emulator/control.h>)
TEST(StreamRays, TakesNoMoreMemoryForMoreRays) {
  const std::vector<Ray> rays = numbered_rays(5000);
  std::vector<float> answers(rays.size());
  const cuda::AnswerArray array{answers.data(), sizeof(float)};
  const std::size_t before = emulator::allocated_bytes();
  constexpr std::size_t kBytes = 36000, kAlignment = 2 * 5 * 256;
  std::size_t most = 0;
  const auto look = [&](const cuda::DeviceRayBatch&, std::span<void* const>, cuda::Stream) {
    most = std::max(most, emulator::allocated_bytes() - before);
  };
  cuda::stream_rays(RayBatch(rays), {&array, 1}, {RayOrder::given, kBytes}, look);
  EXPECT_LE(most, kBytes + kAlignment);
  EXPECT_GT(most, kBytes / 2);
  EXPECT_EQ(emulator::allocated_bytes(), before);
}

TEST(StreamRays, SaysWhereMemoryEnds) {
  const Scene scene;
  emulator::Settings settings = emulator::settings();
  settings.memory_limit = emulator::allocated_bytes() + 1000;
  const std::size_t allocations = emulator::allocation_count();
  {
    const emulator::SettingsScope scope(settings);
    const auto run = [&] { stream(scene.bvh, RayBatch(scene.rays), {}); };
    EXPECT_EQ(test::error_of<cuda::CudaError>(run),
              "could not allocate device memory: out of memory");
  }
  EXPECT_EQ(emulator::allocation_count(), allocations);
  EXPECT_EQ(stream(scene.bvh, RayBatch(scene.rays), {}).hits, scene.host.intersect(scene.rays));
}
#endif

}  // namespace
}  // namespace treelet
