#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include <treelet/core/device_array.h>
#include <treelet/pipeline/device_bvh.h>
#include <treelet/query/all_hits.h>

#include "cuda/device_input.h"
#include "cuda/device_rays.h"

// Lists of hits from a tree in device memory, and the host's in the same form.

namespace treelet::test {

constexpr std::uint32_t kNoLimit = std::numeric_limits<std::uint32_t>::max();

struct HitLists {
  std::vector<std::int64_t> offsets;
  std::vector<Hit> hits;

  friend bool operator==(const HitLists&, const HitLists&) = default;
};

inline HitLists lists_of(const AllHits& all) {
  HitLists lists;
  lists.offsets.assign(all.offsets.begin(), all.offsets.end());
  for (std::size_t i = 0; i < all.size(); ++i) {
    lists.hits.push_back({all.t[i], all.face[i], all.u[i], all.v[i]});
  }
  return lists;
}

inline HitLists list_hits(const cuda::DeviceBvh& bvh, const cuda::DeviceRayBatch& rays,
                          std::uint32_t limit = kNoLimit, RayOrder order = RayOrder::given) {
  cuda::DeviceArray<std::int64_t> offsets(rays.size + 1, kStream);
  const std::size_t size = bvh.offset_hits(rays, limit, offsets.data(), kStream, order);
  cuda::DeviceArray<float> t(size, kStream), u(size, kStream), v(size, kStream);
  cuda::DeviceArray<std::int32_t> face(size, kStream);
  bvh.list_hits(rays, offsets.data(), {t.data(), face.data(), u.data(), v.data()}, kStream, order);
  return lists_of({cuda::download(offsets), cuda::download(t), cuda::download(face),
                   cuda::download(u), cuda::download(v)});
}

inline std::vector<std::int64_t> count_hits(const cuda::DeviceBvh& bvh,
                                            const cuda::DeviceRayBatch& rays,
                                            RayOrder order = RayOrder::given) {
  cuda::DeviceArray<std::int64_t> counts(rays.size, kStream);
  bvh.count_hits(rays, counts.data(), kStream, order);
  const auto host = cuda::download(counts);
  return {host.begin(), host.end()};
}

}  // namespace treelet::test
