#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include <treelet/core/array.h>
#include <treelet/layout/child_view.h>
#include <treelet/primitive/radix_sort.h>

namespace treelet {

/// Where a packed tree holds each of its faces: several positions for one that was split.
class FacePositions {
 public:
  template <class Layout>
  explicit FacePositions(const Layout& bvh) : by_face_(sort_by_face(bvh)) {
    for (std::size_t i = 0; i < by_face_.size(); ++i) {
      if (i == 0 || by_face_[i].key != by_face_[i - 1].key) starts_.push_back(i);
    }
    starts_.push_back(by_face_.size());
  }

  std::size_t entry_count() const { return by_face_.size(); }
  std::size_t face_count() const { return starts_.size() - 1; }

  /// Entries of the face of this rank: the face as key, positions ascending as values.
  std::span<const SortEntry> of_rank(std::size_t rank) const {
    return {by_face_.begin() + starts_[rank], by_face_.begin() + starts_[rank + 1]};
  }

 private:
  template <class Layout>
  static Array<SortEntry> sort_by_face(const Layout& bvh) {
    std::vector<SortEntry> found;
    for (std::size_t i = 0; i < position_count(bvh); ++i) {
      if (has_triangle(bvh, i)) found.push_back({face_at(bvh, i), std::uint32_t(i)});
    }
    Array<SortEntry> entries(found.size());
    std::copy(found.begin(), found.end(), entries.begin());
    radix_sort(entries);
    return entries;
  }

  Array<SortEntry> by_face_;
  std::vector<std::size_t> starts_;
};

}  // namespace treelet
