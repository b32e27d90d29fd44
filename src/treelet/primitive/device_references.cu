#include <treelet/primitive/device_references.h>

#include <algorithm>

#include <treelet/core/device_array.h>
#include <treelet/core/launch.cuh>
#include <treelet/primitive/device_references.cuh>

// Blocks summarize many faces each, then one block combines their summaries: no atomics, and no
// memory that must be cleared before.

namespace treelet::cuda {

struct MeshSummary {
  Aabb bounds;  // of the regular triangles, in the mesh's units
  std::uint32_t regular, non_finite, degenerate;
  std::uint32_t first_bad_face;
};

namespace {

constexpr unsigned kThreads = 256;
constexpr unsigned kWarps = kThreads / kWarpSize;
/// Enough to fill the largest devices, few enough for one block to combine.
constexpr unsigned kMaxBlocks = 1024;

__device__ MeshSummary nothing() { return {Aabb::empty(), 0, 0, 0, DeviceScene::kNoFace}; }

__device__ MeshSummary combine(const MeshSummary& a, const MeshSummary& b) {
  return {merge(a.bounds, b.bounds), a.regular + b.regular, a.non_finite + b.non_finite,
          a.degenerate + b.degenerate, std::min(a.first_bad_face, b.first_bad_face)};
}

__device__ MeshSummary summarize_face(const DeviceMesh& mesh, std::uint32_t face) {
  MeshSummary summary = nothing();
  if (!has_valid_indices(mesh, face)) {
    summary.first_bad_face = face;
    return summary;
  }
  const Triangle triangle = triangle_of(mesh, face);
  const TriangleKind kind = classify(triangle);
  summary.regular = kind == TriangleKind::regular;
  summary.non_finite = kind == TriangleKind::non_finite;
  summary.degenerate = kind == TriangleKind::degenerate;
  if (summary.regular) summary.bounds = bounds(triangle);
  return summary;
}

__device__ Vec3 shuffle(Vec3 p, int distance) {
  return {__shfl_xor_sync(kFullWarp, p.x, distance), __shfl_xor_sync(kFullWarp, p.y, distance),
          __shfl_xor_sync(kFullWarp, p.z, distance)};
}

/// The summary of the lane whose index differs in one bit.
__device__ MeshSummary shuffle(const MeshSummary& s, int distance) {
  return {{shuffle(s.bounds.lower, distance), shuffle(s.bounds.upper, distance)},
          __shfl_xor_sync(kFullWarp, s.regular, distance),
          __shfl_xor_sync(kFullWarp, s.non_finite, distance),
          __shfl_xor_sync(kFullWarp, s.degenerate, distance),
          __shfl_xor_sync(kFullWarp, s.first_bad_face, distance)};
}

__device__ MeshSummary combine_warp(MeshSummary summary) {
  for (int distance = kWarpSize / 2; distance > 0; distance /= 2) {
    summary = combine(summary, shuffle(summary, distance));
  }
  return summary;
}

/// For the whole block; its first warp gets the result.
__device__ MeshSummary combine_block(const MeshSummary& mine) {
  __shared__ MeshSummary of_warp[kWarps];
  const MeshSummary summary = combine_warp(mine);
  if (lane_index() == 0) of_warp[threadIdx.x / kWarpSize] = summary;
  __syncthreads();
  return combine_warp(threadIdx.x < kWarps ? of_warp[threadIdx.x] : nothing());
}

__device__ DeviceScene make_scene(const MeshSummary& mesh) {
  const int exponent = extent_exponent(mesh.bounds);
  const PowerOfTwoScale scale(exponent);
  const Aabb bounds = mesh.regular > 0 ? scale(mesh.bounds) : Aabb::empty();
  return {bounds,          exponent,        make_morton_grid(bounds), mesh.regular,
          mesh.non_finite, mesh.degenerate, mesh.first_bad_face};
}

__global__ void summarize_faces(DeviceMesh mesh, MeshSummary* summaries) {
  MeshSummary mine = nothing();
  for (std::uint32_t i = thread_index(); i < mesh.face_count; i += gridDim.x * kThreads) {
    mine = combine(mine, summarize_face(mesh, i));
  }
  const MeshSummary all = combine_block(mine);
  if (threadIdx.x == 0) summaries[blockIdx.x] = all;
}

__global__ void combine_summaries(const MeshSummary* summaries, unsigned count,
                                  DeviceScene* scene) {
  MeshSummary mine = nothing();
  for (unsigned i = threadIdx.x; i < count; i += kThreads) mine = combine(mine, summaries[i]);
  const MeshSummary all = combine_block(mine);
  if (threadIdx.x == 0) *scene = make_scene(all);
}

}  // namespace

MeshSummary* carve_summaries(Carver& carver) { return carver.take<MeshSummary>(kMaxBlocks); }

void survey_mesh(const DeviceMesh& mesh, MeshSummary* summaries, DeviceScene* scene,
                 Stream stream) {
  const unsigned blocks = std::min(thread_each(mesh.face_count, kThreads).blocks, kMaxBlocks);
  launch(stream, {blocks, kThreads}, summarize_faces, mesh, summaries);
  launch(stream, {1, kThreads}, combine_summaries, summaries, blocks, scene);
}

void require_valid_indices(const DeviceMesh& mesh, const DeviceScene& scene, Stream stream) {
  const std::uint32_t face = scene.first_bad_face;
  if (face == DeviceScene::kNoFace) return;
  throw_bad_index(face, download(mesh.faces + face, 1, stream)[0], mesh.vertex_count);
}

}  // namespace treelet::cuda
