#include <treelet/pipeline/device_bvh.h>

#include <treelet/core/no_cuda.h>

namespace treelet::cuda {

class DeviceBvh::Impl {};

DeviceBvh::DeviceBvh(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
DeviceBvh::DeviceBvh(DeviceBvh&&) noexcept = default;
DeviceBvh& DeviceBvh::operator=(DeviceBvh&&) noexcept = default;
DeviceBvh::~DeviceBvh() = default;

DeviceBvh DeviceBvh::build(const DeviceMesh&, const Recipe&, const DeviceBuildOptions&, Stream) {
  throw_no_cuda();
}
DeviceBvh DeviceBvh::upload(const Bvh&, Stream) { throw_no_cuda(); }
Bvh DeviceBvh::download(Stream) const { throw_no_cuda(); }
const BuildReport& DeviceBvh::report() const { throw_no_cuda(); }
int DeviceBvh::device() const { throw_no_cuda(); }
Aabb DeviceBvh::bounds() const { throw_no_cuda(); }
double DeviceBvh::epo(std::size_t) const { throw_no_cuda(); }
void DeviceBvh::refit(const Vec3*, std::uint32_t, Stream) { throw_no_cuda(); }
void DeviceBvh::rebuild(const Vec3*, std::uint32_t, Stream) { throw_no_cuda(); }
void DeviceBvh::check(Stream) { throw_no_cuda(); }
void DeviceBvh::intersect(const DeviceRayBatch&, const HitArrays&, Stream, RayOrder) const {
  throw_no_cuda();
}
void DeviceBvh::find_occluded(const DeviceRayBatch&, bool*, Stream, RayOrder) const {
  throw_no_cuda();
}
void DeviceBvh::count_work(const DeviceRayBatch&, const WorkArrays&, Stream, RayOrder) const {
  throw_no_cuda();
}
std::size_t DeviceBvh::offset_hits(const DeviceRayBatch&, std::uint32_t, std::int64_t*, Stream,
                                   RayOrder) const {
  throw_no_cuda();
}
void DeviceBvh::list_hits(const DeviceRayBatch&, const std::int64_t*, const HitArrays&, Stream,
                          RayOrder) const {
  throw_no_cuda();
}
void DeviceBvh::count_hits(const DeviceRayBatch&, std::int64_t*, Stream, RayOrder) const {
  throw_no_cuda();
}
void DeviceBvh::closest_point(const DevicePointBatch&, const ClosestPointArrays&, Stream) const {
  throw_no_cuda();
}
void DeviceBvh::contains(const DevicePointBatch&, bool*, Stream) const { throw_no_cuda(); }
void DeviceBvh::signed_distance(const DevicePointBatch&, float*, Stream) const { throw_no_cuda(); }
void DeviceBvh::intersect(const RayBatch&, const HitArrays&, const StreamOptions&) const {
  throw_no_cuda();
}
void DeviceBvh::find_occluded(const RayBatch&, bool*, const StreamOptions&) const {
  throw_no_cuda();
}
void DeviceBvh::count_work(const RayBatch&, const WorkArrays&, const StreamOptions&) const {
  throw_no_cuda();
}
void DeviceBvh::count_hits(const RayBatch&, std::uint32_t, std::int64_t*,
                           const StreamOptions&) const {
  throw_no_cuda();
}

}  // namespace treelet::cuda
