#pragma once

#include <cstddef>
#include <functional>
#include <span>

#include <treelet/core/stream.h>
#include <treelet/query/device_rays.h>
#include <treelet/query/ray_batch.h>
#include <treelet/query/ray_order.h>

namespace treelet::cuda {

/// How rays on the host are answered by a device.
struct StreamOptions {
  RayOrder order = RayOrder::given;
  /// About what rays, answers and their order take there, however many rays there are.
  std::size_t device_bytes = std::size_t{1} << 28;
};

/// Answers on the host: so many bytes a ray, one ray's after the other's.
struct AnswerArray {
  void* first;
  std::size_t bytes;
};

/// Enqueues the tracing of rays in device memory; each kind of answers goes to an array there.
using TraceChunk =
    std::function<void(const DeviceRayBatch& rays, std::span<void* const> answers, Stream stream)>;

/// Answers rays that lie on the host, of which any part may be memory-mapped: sends them to the
/// current device chunk by chunk, has them traced and brings the answers back; waits for the last.
/// Two chunks are there at a time, each on a stream of its own, so that one is traced while the
/// other is copied; from pinned memory copies run beside each other, too. After an error nothing is
/// under way any more, and answers of some rays are missing.
void stream_rays(const RayBatch& rays, std::span<const AnswerArray> answers,
                 const StreamOptions& options, const TraceChunk& trace);

}  // namespace treelet::cuda
