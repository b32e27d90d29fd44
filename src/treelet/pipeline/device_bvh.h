#pragma once

#include <memory>

#include <treelet/core/cuda_error.h>
#include <treelet/core/stream.h>
#include <treelet/pipeline/bvh.h>
#include <treelet/pipeline/recipe.h>
#include <treelet/primitive/device_references.h>
#include <treelet/query/closest_point.h>
#include <treelet/query/device_intersect.h>
#include <treelet/query/device_points.h>
#include <treelet/query/ray_order.h>
#include <treelet/query/stream_rays.h>

namespace treelet::cuda {

struct DeviceBuildOptions {
  bool validate = false;   ///< check the binary tree after every stage
  bool updatable = false;  ///< keep what refit and rebuild need; the build waits once more
};

/// A tree in the memory of a CUDA device: what Bvh (pipeline/bvh.h) is on the host, with the same
/// answers, bit for bit. All arrays that a call takes lie on that device. Work is enqueued on the
/// stream that a call names; where it has to wait for the device, it says so. Where the library was
/// built without CUDA or there is no GPU, making one throws CudaError.
class DeviceBvh {
 public:
  DeviceBvh(DeviceBvh&&) noexcept;
  DeviceBvh& operator=(DeviceBvh&&) noexcept;
  ~DeviceBvh();

  /// Builds a tree where the mesh lies; the mesh is not needed after what was enqueued. Throws as
  /// build() on the host, and for recipe words that run on the CPU alone. Waits once: for the sizes
  /// of the arrays to allocate, by when all that can be wrong with the mesh is known.
  static DeviceBvh build(const DeviceMesh& mesh, const Recipe& recipe,
                         const DeviceBuildOptions& options, Stream stream);

  /// Moves a host's tree to the current device. Waits for the copy.
  static DeviceBvh upload(const Bvh& bvh, Stream stream);
  /// Moves the tree to the host. Waits for the copy.
  Bvh download(Stream stream) const;

  /// What the build did; waits for it the first time. Seconds are the device's, stage by stage.
  const BuildReport& report() const;
  int device() const;
  /// Waits for what was enqueued on the stream of the last build or update.
  Aabb bounds() const;
  /// As Bvh::epo on the host; waits.
  double epo(std::size_t max_triangles = 0) const;

  /// As UpdatableBvh::refit on the host, from vertices in device memory. Nothing waits; the report,
  /// when it is read next, tells the layout's SAH and what is hidden. Only for updatable trees.
  void refit(const Vec3* vertices, std::uint32_t count, Stream stream);
  /// Runs the recipe again over moved vertices, in the memory that the tree has. Nothing waits and
  /// nothing is allocated, so that a CUDA graph can record it; what went wrong, check() tells. Only
  /// for updatable trees.
  void rebuild(const Vec3* vertices, std::uint32_t count, Stream stream);
  /// Waits for the last rebuild and brings the report up to date. Throws CudaError where the tree
  /// did not fit the memory it has; it then has more, and the next rebuild fits.
  void check(Stream stream);

  // One answer a ray, as on the host; outputs are in device memory.
  void intersect(const DeviceRayBatch& rays, const HitArrays& hits, Stream stream,
                 RayOrder order = RayOrder::given) const;
  void find_occluded(const DeviceRayBatch& rays, bool* occluded, Stream stream,
                     RayOrder order = RayOrder::given) const;
  void count_work(const DeviceRayBatch& rays, const WorkArrays& work, Stream stream,
                  RayOrder order = RayOrder::given) const;

  // All crossings, as on the host (query/all_hits.h), in two steps: the first makes rays.size + 1
  // offsets, waits, and returns the last, for so many hits there must be room; the second writes
  // them. Of each ray the first hits up to a limit.
  std::size_t offset_hits(const DeviceRayBatch& rays, std::uint32_t limit, std::int64_t* offsets,
                          Stream stream, RayOrder order = RayOrder::given) const;
  void list_hits(const DeviceRayBatch& rays, const std::int64_t* offsets, const HitArrays& hits,
                 Stream stream, RayOrder order = RayOrder::given) const;
  void count_hits(const DeviceRayBatch& rays, std::int64_t* counts, Stream stream,
                  RayOrder order = RayOrder::given) const;

  // One answer a point, as on the host; outputs are in device memory.
  void closest_point(const DevicePointBatch& points, const ClosestPointArrays& answers,
                     Stream stream) const;
  void contains(const DevicePointBatch& points, bool* answers, Stream stream) const;
  void signed_distance(const DevicePointBatch& points, float* answers, Stream stream) const;

  // Rays and answers on the host, sent to and fro in chunks (query/stream_rays.h). Wait.
  void intersect(const RayBatch& rays, const HitArrays& hits,
                 const StreamOptions& options = {}) const;
  void find_occluded(const RayBatch& rays, bool* occluded, const StreamOptions& options = {}) const;
  void count_work(const RayBatch& rays, const WorkArrays& work,
                  const StreamOptions& options = {}) const;
  /// Counts up to a limit.
  void count_hits(const RayBatch& rays, std::uint32_t limit, std::int64_t* counts,
                  const StreamOptions& options = {}) const;

 private:
  class Impl;
  explicit DeviceBvh(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace treelet::cuda
