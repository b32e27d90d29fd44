#pragma once

#include <algorithm>
#include <cstddef>

namespace treelet::cuda {

/// Cuts one block of memory into arrays; without a block it only counts what they would take. The
/// function that lays out a build's memory runs twice: first to count, then to cut.
///
///     used:  | codes | nodes      |            rewind(mark) frees what came after a mark, and what
///            | codes | nodes | costs | cut |   is taken next lies where it was
class Carver {
 public:
  explicit Carver(void* block = nullptr) : block_(static_cast<std::byte*>(block)) {}

  template <class T>
  T* take(std::size_t count) {
    const std::size_t begin = used_;
    used_ += (count * sizeof(T) + kAlignment - 1) / kAlignment * kAlignment;
    peak_ = std::max(peak_, used_);
    return block_ == nullptr ? nullptr : reinterpret_cast<T*>(block_ + begin);
  }

  std::size_t used() const { return used_; }
  void rewind(std::size_t mark) { used_ = mark; }
  /// Bytes the block needs.
  std::size_t peak() const { return peak_; }

 private:
  static constexpr std::size_t kAlignment = 256;  // as of an allocation of its own

  std::byte* block_;
  std::size_t used_ = 0;
  std::size_t peak_ = 0;
};

}  // namespace treelet::cuda
