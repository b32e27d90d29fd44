#include <treelet/pipeline/device_bvh.h>

#include <treelet/core/cuda_error.h>

namespace treelet::cuda {
namespace {

[[noreturn]] void throw_no_cuda() {
  throw CudaError("this build of treelet has no CUDA: build it with TREELET_CUDA=ON");
}

}  // namespace

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
void DeviceBvh::intersect(const DeviceRayBatch&, const HitArrays&, Stream) const {
  throw_no_cuda();
}
void DeviceBvh::find_occluded(const DeviceRayBatch&, bool*, Stream) const { throw_no_cuda(); }
void DeviceBvh::count_work(const DeviceRayBatch&, const WorkArrays&, Stream) const {
  throw_no_cuda();
}

}  // namespace treelet::cuda
