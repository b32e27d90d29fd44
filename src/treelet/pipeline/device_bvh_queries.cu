#include <limits>
#include <span>

#include <treelet/core/device_scope.h>
#include <treelet/pipeline/device_bvh_impl.h>
#include <treelet/primitive/device_sort.h>
#include <treelet/query/device_closest_point.h>
#include <treelet/query/device_contains.h>
#include <treelet/query/device_queries.h>
#include <treelet/query/stream_rays.h>

// Queries of a DeviceBvh: rays on the device are enqueued, rays on the host are streamed through
// it.

namespace treelet::cuda {

template <class Query>
void DeviceBvh::Impl::trace(const DeviceRayBatch& rays, RayOrder order, const Query& query,
                            Stream stream) const {
  read(stream,
       [&](const auto& bvh) { trace_rays_in_order(bvh, depth, rays, order, query, stream); });
}

/// Queries rays on the host. All is done on return, so nothing need wait for it later.
template <class Query>
void DeviceBvh::Impl::trace(const RayBatch& rays, const StreamOptions& options,
                            const Query& query) const {
  const DeviceScope scope(device);
  const auto trace_chunk = [&](const DeviceRayBatch& chunk, std::span<void* const> arrays,
                               Stream stream) {
    writes.order_behind(stream);
    visit([&](const auto& bvh) {
      trace_rays_in_order(bvh, depth, chunk, options.order, query.into(arrays), stream);
    });
  };
  stream_rays(rays, query.answers(), options, trace_chunk);
}

void DeviceBvh::intersect(const DeviceRayBatch& rays, const HitArrays& hits, Stream stream,
                          RayOrder order) const {
  impl_->trace(rays, order, ClosestHitQuery{hits}, stream);
}
void DeviceBvh::find_occluded(const DeviceRayBatch& rays, bool* occluded, Stream stream,
                              RayOrder order) const {
  impl_->trace(rays, order, AnyHitQuery{occluded}, stream);
}
void DeviceBvh::count_work(const DeviceRayBatch& rays, const WorkArrays& work, Stream stream,
                           RayOrder order) const {
  impl_->trace(rays, order, WorkQuery{work}, stream);
}

void DeviceBvh::intersect(const RayBatch& rays, const HitArrays& hits,
                          const StreamOptions& options) const {
  impl_->trace(rays, options, ClosestHitQuery{hits});
}
void DeviceBvh::find_occluded(const RayBatch& rays, bool* occluded,
                              const StreamOptions& options) const {
  impl_->trace(rays, options, AnyHitQuery{occluded});
}
void DeviceBvh::count_work(const RayBatch& rays, const WorkArrays& work,
                           const StreamOptions& options) const {
  impl_->trace(rays, options, WorkQuery{work});
}
void DeviceBvh::count_hits(const RayBatch& rays, std::uint32_t limit, std::int64_t* counts,
                           const StreamOptions& options) const {
  impl_->trace(rays, options, HitCountQuery{counts, limit, impl_->facts()});
}

void DeviceBvh::count_hits(const DeviceRayBatch& rays, std::int64_t* counts, Stream stream,
                           RayOrder order) const {
  constexpr std::uint32_t kNoLimit = std::numeric_limits<std::uint32_t>::max();
  impl_->trace(rays, order, HitCountQuery{counts, kNoLimit, impl_->facts()}, stream);
}

std::size_t DeviceBvh::offset_hits(const DeviceRayBatch& rays, std::uint32_t limit,
                                   std::int64_t* offsets, Stream stream, RayOrder order) const {
  const DeviceScope scope(impl_->device);
  fill_device_bytes(offsets + rays.size, 0, sizeof(*offsets), stream);
  impl_->trace(rays, order, HitCountQuery{offsets, limit, impl_->facts()}, stream);
  sum_before(offsets, rays.size + 1, stream);
  std::int64_t total = 0;
  copy_to_host(&total, offsets + rays.size, sizeof(total), stream);
  return std::size_t(total);
}

void DeviceBvh::list_hits(const DeviceRayBatch& rays, const std::int64_t* offsets,
                          const HitArrays& hits, Stream stream, RayOrder order) const {
  impl_->trace(rays, order, HitListQuery{offsets, hits, impl_->facts()}, stream);
}

void DeviceBvh::closest_point(const DevicePointBatch& points, const ClosestPointArrays& answers,
                              Stream stream) const {
  impl_->read(stream, [&](const auto& bvh) {
    treelet::cuda::closest_point(bvh, impl_->depth, points, answers, stream);
  });
}
void DeviceBvh::contains(const DevicePointBatch& points, bool* answers, Stream stream) const {
  impl_->read(stream, [&](const auto& bvh) {
    treelet::cuda::contains(bvh, impl_->facts(), points, answers, stream);
  });
}
void DeviceBvh::signed_distance(const DevicePointBatch& points, float* answers,
                                Stream stream) const {
  impl_->read(stream, [&](const auto& bvh) {
    treelet::cuda::signed_distance(bvh, impl_->facts(), points, answers, stream);
  });
}

}  // namespace treelet::cuda
