#pragma once

#include <treelet/core/device_array.h>
#include <treelet/pipeline/device_bvh.h>
#include <treelet/query/device_rays.h>

#include <cstddef>
#include <span>
#include <vector>

#include "cuda/device_input.h"

// Rays in device memory, and all that a tree answers them.

namespace treelet::test {

class DeviceRays {
 public:
  explicit DeviceRays(std::span<const Ray> rays) : rays_(upload_all(rays)) {}

  cuda::DeviceRayBatch batch() const {
    cuda::DeviceRayBatch batch;
    batch.size = rays_.size();
    if (rays_.empty()) return batch;
    const Ray* const first = rays_.data();
    batch.origins = {&first->origin, sizeof(Ray)};
    batch.directions = {&first->direction, sizeof(Ray)};
    batch.t_min = {&first->t_min, sizeof(Ray)};
    batch.t_max = {&first->t_max, sizeof(Ray)};
    return batch;
  }

 private:
  cuda::DeviceArray<Ray> rays_;
};

/// Room on the host for all answers.
struct Answers {
  std::vector<Hit> hits;
  std::vector<bool> occluded;
  std::vector<std::uint32_t> nodes, triangles;

  friend bool operator==(const Answers&, const Answers&) = default;
};

inline Answers trace(const cuda::DeviceBvh& bvh, const DeviceRays& rays, RayOrder order) {
  const cuda::DeviceRayBatch batch = rays.batch();
  const auto room = [&]<class T>(T) { return cuda::DeviceArray<T>(batch.size, kStream); };
  auto t = room(0.0f), u = room(0.0f), v = room(0.0f);
  auto face = room(std::int32_t{});
  auto occluded = room(false);
  auto nodes = room(std::uint32_t{}), triangles = room(std::uint32_t{});
  bvh.intersect(batch, {t.data(), face.data(), u.data(), v.data()}, kStream, order);
  bvh.find_occluded(batch, occluded.data(), kStream, order);
  bvh.count_work(batch, {nodes.data(), triangles.data()}, kStream, order);
  const auto ts = cuda::download(t), us = cuda::download(u), vs = cuda::download(v);
  const auto faces = cuda::download(face);
  Answers answers;
  for (std::size_t i = 0; i < batch.size; ++i) {
    answers.hits.push_back({ts[i], faces[i], us[i], vs[i]});
  }
  const auto copy = [](const auto& device, auto& to) {
    const auto values = cuda::download(device);
    to.assign(values.begin(), values.end());
  };
  copy(occluded, answers.occluded);
  copy(nodes, answers.nodes);
  copy(triangles, answers.triangles);
  return answers;
}

}  // namespace treelet::test
