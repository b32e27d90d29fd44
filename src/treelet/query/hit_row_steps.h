#pragma once

#include <cstddef>
#include <cstdint>

#include <treelet/core/platform.h>
#include <treelet/core/ray.h>
#include <treelet/query/intersect.h>

// Rows of hits, one ray's each, in memory that a thread of a device has to itself: sorted as those
// of query/hit_rows.h are, without taking more memory.

namespace treelet {

/// The order of hits in a row.
TREELET_HD inline bool comes_before(const Hit& a, const Hit& b) {
  return a.t < b.t || (a.t == b.t && a.face < b.face);
}

/// Hits at [0, size) of four arrays.
struct HitRow {
  HitArrays arrays;
  std::uint32_t size = 0;

  TREELET_HD Hit operator[](std::uint32_t i) const {
    return {arrays.t[i], arrays.face[i], arrays.u[i], arrays.v[i]};
  }
  TREELET_HD void push(const Hit& hit) { arrays.set(size++, hit); }
};

namespace hit_row_steps {

/// Few hits, in which most rows end, are sorted the fastest by insertion.
constexpr std::uint32_t kFew = 16;

TREELET_HD inline void sort_by_insertion(const HitRow& row) {
  for (std::uint32_t i = 1; i < row.size; ++i) {
    const Hit hit = row[i];
    std::uint32_t place = i;
    for (; place > 0 && comes_before(hit, row[place - 1]); --place) {
      row.arrays.set(place, row[place - 1]);
    }
    row.arrays.set(place, hit);
  }
}

/// Puts a hit at or below a node of the heap of the first `size` hits.
TREELET_HD inline void sift_down(const HitRow& row, std::uint32_t node, std::uint32_t size,
                                 const Hit& hit) {
  while (size > 1 && node <= (size - 2) / 2) {
    std::uint32_t child = 2 * node + 1;
    if (child + 1 < size && comes_before(row[child], row[child + 1])) ++child;
    if (!comes_before(hit, row[child])) break;
    row.arrays.set(node, row[child]);
    node = child;
  }
  row.arrays.set(node, hit);
}

/// A heap with the row's last hit at its root.
TREELET_HD inline void make_heap(const HitRow& row) {
  for (std::uint32_t node = row.size / 2; node-- > 0;) sift_down(row, node, row.size, row[node]);
}

TREELET_HD inline void sort_by_heap(const HitRow& row) {
  make_heap(row);
  for (std::uint32_t last = row.size - 1; last > 0; --last) {
    const Hit hit = row[last];
    row.arrays.set(last, row[0]);
    sift_down(row, 0, last, hit);
  }
}

}  // namespace hit_row_steps

/// By t, of equal t by face.
TREELET_HD inline void sort(const HitRow& row) {
  if (row.size <= hit_row_steps::kFew) return hit_row_steps::sort_by_insertion(row);
  hit_row_steps::sort_by_heap(row);
}

/// Sorts, and keeps one of those that a split triangle has in several leaves.
TREELET_HD inline void sort_unique(HitRow& row) {
  sort(row);
  std::uint32_t kept = 0;
  for (std::uint32_t i = 0; i < row.size; ++i) {
    const Hit hit = row[i];
    if (kept == 0 || row.arrays.face[kept - 1] != hit.face) row.arrays.set(kept++, hit);
  }
  row.size = kept;
}

}  // namespace treelet
