#include <treelet/query/stream_rays.h>

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <vector>

#include <treelet/core/array.h>
#include <treelet/core/carver.h>
#include <treelet/core/device_array.h>
#include <treelet/core/parallel.h>
#include <treelet/core/cuda_check.cuh>

namespace treelet::cuda {
namespace {

/// A stream while it lives; other streams do not wait for it.
class OwnedStream {
 public:
  OwnedStream() {
    check(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking), "create a stream");
  }
  ~OwnedStream() {
    if (cudaStreamDestroy(stream_) != cudaSuccess) cudaGetLastError();
  }
  OwnedStream(const OwnedStream&) = delete;
  operator Stream() const { return stream_; }

 private:
  Stream stream_ = nullptr;
};

/// One part of the rays of a chunk, in device memory.
template <class T>
class SentValues {
 public:
  /// Room for one value where all rays share it.
  void carve(Carver& carver, const PerRay<T>& values, std::size_t capacity) {
    is_shared_ = values.stride == 0;
    device_ = carver.take<T>(is_shared_ ? 1 : capacity);
  }

  PerRay<T> send(const PerRay<T>& values, std::size_t count, Stream stream) {
    if (is_shared_) count = 1;
    const bool is_dense = is_shared_ || values.stride == sizeof(T);
    const void* const source = is_dense ? values.first : gather(values, count);
    copy_to_device(device_, source, count * sizeof(T), stream);
    return {device_, is_shared_ ? 0 : sizeof(T)};
  }

 private:
  const std::byte* gather(const PerRay<T>& values, std::size_t count) {
    if (gathered_.size() < count) gathered_ = Array<T>(count);
    parallel_for(count, 1 << 14, [&](std::size_t i) { gathered_[i] = values[i]; });
    return reinterpret_cast<const std::byte*>(gathered_.data());
  }

  T* device_ = nullptr;
  bool is_shared_ = false;
  Array<T> gathered_;  ///< kept until the chunk's answers are there
};

/// The parts of a chunk's rays and its answers in device memory.
struct ChunkMemory {
  SentValues<Vec3> origins, directions;
  SentValues<float> t_min, t_max;
  std::vector<void*> answers;

  void carve(Carver& carver, const RayBatch& rays, std::span<const AnswerArray> arrays,
             std::size_t capacity) {
    origins.carve(carver, rays.origins, capacity);
    directions.carve(carver, rays.directions, capacity);
    t_min.carve(carver, rays.t_min, capacity);
    t_max.carve(carver, rays.t_max, capacity);
    answers.clear();
    for (const AnswerArray& array : arrays) {
      answers.push_back(carver.take<std::byte>(capacity * array.bytes));
    }
  }

  DeviceRayBatch send(const RayBatch& rays, Stream stream) {
    DeviceRayBatch sent;
    sent.size = rays.size;
    sent.origins = origins.send(rays.origins, rays.size, stream);
    sent.directions = directions.send(rays.directions, rays.size, stream);
    sent.t_min = t_min.send(rays.t_min, rays.size, stream);
    sent.t_max = t_max.send(rays.t_max, rays.size, stream);
    return sent;
  }
};

/// A place on the device for one chunk at a time.
class Slot {
 public:
  Slot(const RayBatch& rays, std::span<const AnswerArray> arrays, std::size_t capacity)
      : arrays_(arrays) {
    Carver counting;
    memory_.carve(counting, rays, arrays, capacity);
    block_ = DeviceArray<std::byte>(counting.peak(), stream_);
    Carver carver(block_.data());
    memory_.carve(carver, rays, arrays, capacity);
  }
  /// After an error copies to and from the caller's memory may be under way.
  ~Slot() {
    if (cudaStreamSynchronize(stream_) != cudaSuccess) cudaGetLastError();
  }

  /// Waits until the answers of the chunk before are on the host.
  void begin(const RayBatch& rays, std::size_t first, const TraceChunk& trace) {
    synchronize(stream_);
    first_ = first;
    count_ = rays.size;
    trace(memory_.send(rays, stream_), memory_.answers, stream_);
  }

  /// Enqueues the copy of the answers, or waits for it where the host's memory is pageable.
  void fetch() {
    for (std::size_t i = 0; i < arrays_.size() && count_ > 0; ++i) {
      const std::size_t bytes = arrays_[i].bytes;
      void* const host = static_cast<std::byte*>(arrays_[i].first) + first_ * bytes;
      check(cudaMemcpyAsync(host, memory_.answers[i], count_ * bytes, cudaMemcpyDeviceToHost,
                            stream_),
            "copy answers from the device");
    }
    count_ = 0;
  }

  void finish() {
    fetch();
    synchronize(stream_);
  }

 private:
  OwnedStream stream_;
  std::span<const AnswerArray> arrays_;
  DeviceArray<std::byte> block_;
  ChunkMemory memory_;
  std::size_t first_ = 0, count_ = 0;  ///< of the chunk whose answers are not fetched
};

/// Rays that two slots hold in the bytes there are.
std::size_t chunk_size(const RayBatch& rays, std::span<const AnswerArray> answers,
                       const StreamOptions& options) {
  constexpr std::size_t kOrderBytes = 16;  // query/ray_order.h
  const auto bytes_of = [](const auto& values) {
    return values.stride == 0 ? 0 : sizeof(values[0]);
  };
  std::size_t bytes = options.order == RayOrder::given ? 0 : kOrderBytes;
  bytes += bytes_of(rays.origins) + bytes_of(rays.directions);
  bytes += bytes_of(rays.t_min) + bytes_of(rays.t_max);
  for (const AnswerArray& array : answers) bytes += array.bytes;
  return std::clamp<std::size_t>(options.device_bytes / 2 / bytes, 1, rays.size);
}

}  // namespace

void stream_rays(const RayBatch& rays, std::span<const AnswerArray> answers,
                 const StreamOptions& options, const TraceChunk& trace) {
  if (rays.active.first != nullptr || !rays.filter.is_open()) {
    throw std::invalid_argument(
        "a device traces all rays against all faces: trace masks on the CPU");
  }
  if (rays.size == 0) return;
  const std::size_t capacity = chunk_size(rays, answers, options);
  std::optional<Slot> slots[2];
  for (std::size_t chunk = 0, first = 0; first < rays.size; ++chunk, first += capacity) {
    std::optional<Slot>&slot = slots[chunk % 2], &other = slots[(chunk + 1) % 2];
    if (!slot) slot.emplace(rays, answers, capacity);
    slot->begin(rays.part(first, std::min(capacity, rays.size - first)), first, trace);
    if (other) other->fetch();  // while the device traces this chunk
  }
  for (std::optional<Slot>& slot : slots) {
    if (slot) slot->finish();
  }
}

}  // namespace treelet::cuda
