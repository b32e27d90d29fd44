#pragma once

#include <cstdint>
#include <limits>

#include <treelet/core/platform.h>
#include <treelet/core/ray.h>
#include <treelet/query/hit_row_steps.h>

namespace treelet {

/// A ray's hits beyond some hit, in the order of rows, as many as fit; each face once. A ray that
/// has more is traced again for those beyond the last: so rows of any length are sorted, freed of
/// what split triangles repeat, and cut to a limit, in memory of one size.
class HitWindow {
 public:
  /// Of at least two hits.
  TREELET_HD HitWindow(const HitArrays& memory, std::uint32_t capacity)
      : row_{memory}, capacity_(capacity) {}

  /// The first window has all hits ahead of it.
  TREELET_HD void begin() { begin(before_all()); }
  /// To hold what comes after this window.
  TREELET_HD void advance() { begin(last_); }

  /// Takes hits in any order.
  TREELET_HD void add(const Hit& hit) {
    if (!comes_before(before_, hit) || comes_before(last_, hit)) return;
    if (row_.size == capacity_) {
      make_room();
      if (comes_before(last_, hit)) return;
    }
    row_.push(hit);
  }

  /// No window before this one holds hits from here on; none of smaller t is looked for.
  TREELET_HD float t_min() const { return before_.t; }
  /// No hit beyond fits.
  TREELET_HD float t_limit() const { return last_.t; }

  /// The hits, once all were added.
  TREELET_HD const HitRow& finish() {
    sort_unique(row_);
    return row_;
  }
  /// Whether hits beyond may have been given up.
  TREELET_HD bool was_cut() const { return was_cut_; }

 private:
  TREELET_HD static Hit before_all() {
    return {-std::numeric_limits<float>::infinity(), -1, 0.0f, 0.0f};
  }
  TREELET_HD static Hit after_all() {
    return {std::numeric_limits<float>::infinity(), std::numeric_limits<std::int32_t>::max(), 0.0f,
            0.0f};
  }

  TREELET_HD void begin(const Hit& before) {
    before_ = before;
    last_ = after_all();
    row_.size = 0;
    was_cut_ = false;
  }

  /// Gives up the later half, where repetitions alone do not leave as much.
  TREELET_HD void make_room() {
    sort_unique(row_);
    if (row_.size <= capacity_ / 2) return;
    row_.size = capacity_ / 2;
    last_ = row_[row_.size - 1];
    was_cut_ = true;
  }

  HitRow row_;
  std::uint32_t capacity_;
  Hit before_ = before_all();  ///< excluded
  Hit last_ = after_all();     ///< included
  bool was_cut_ = false;
};

}  // namespace treelet
