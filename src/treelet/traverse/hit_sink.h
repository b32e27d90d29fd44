#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include <treelet/core/platform.h>
#include <treelet/traverse/ray_triangle.h>

namespace treelet {

/// A crossing of one of a batch's rays.
struct RayHit {
  std::uint32_t ray;
  std::int32_t face;
  float t, u, v;

  friend bool operator==(const RayHit&, const RayHit&) = default;
};

/// What counting needs of it.
struct RayFace {
  std::uint32_t ray;
  std::int32_t face;

  friend bool operator==(const RayFace&, const RayFace&) = default;
};

/// Takes what a traversal finds, in any order, and grows. Kernels of several instruction sets
/// inline push().
template <class Record>
class HitSink {
 public:
  /// Records from which on a traversal should start no further ray: what lies here is small then.
  static constexpr std::size_t kEnough = std::size_t{1} << 18;

  TREELET_INLINE void push(const Record& record) {
    if (next_ == end_) [[unlikely]]
      grow();
    *next_++ = record;
  }
  TREELET_INLINE bool has_enough() const { return std::size_t(next_ - begin_) >= kEnough; }

  std::span<const Record> records() const { return {begin_, next_}; }
  void clear() { next_ = begin_; }

 private:
  TREELET_NOINLINE void grow();

  std::unique_ptr<Record[]> memory_;
  Record *begin_ = nullptr, *next_ = nullptr, *end_ = nullptr;
};

extern template class HitSink<RayHit>;
extern template class HitSink<RayFace>;

}  // namespace treelet
