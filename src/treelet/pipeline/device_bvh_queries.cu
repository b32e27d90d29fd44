#include <span>

#include <treelet/core/device_scope.h>
#include <treelet/pipeline/device_bvh_impl.h>
#include <treelet/query/device_intersect.h>
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
      trace_rays_in_order(bvh, depth, chunk, options.order, Query::into(arrays), stream);
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

}  // namespace treelet::cuda
