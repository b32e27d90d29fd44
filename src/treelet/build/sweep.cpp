#include <treelet/build/sweep.h>

#include <array>
#include <bit>
#include <limits>

#include <treelet/build/top_down.h>
#include <treelet/core/parallel.h>
#include <treelet/core/stage.h>
#include <treelet/primitive/radix_sort.h>
#include <treelet/tree/refit.h>

namespace treelet {
namespace {

constexpr std::size_t kGrain = 1 << 14;

/// References [begin, end) of each axis' order, to become the subtree at `slot`.
struct Range {
  std::size_t begin = 0, end = 0;
  std::uint32_t slot = kRoot;

  std::size_t count() const { return end - begin; }
};

struct Split {
  double cost = std::numeric_limits<double>::infinity();
  int axis = 0;
  std::size_t position = 0;   // of the first reference on the right
  std::size_t imbalance = 0;  // decides between equal costs: identical boxes must not make a chain

  bool better_than(const Split& other) const {
    return cost != other.cost ? cost < other.cost : imbalance < other.imbalance;
  }
};

/// Floats to integers of the same order.
std::uint64_t sortable(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value + 0.0f);  // -0 to +0
  return bits >> 31 != 0 ? ~bits : bits | 0x80000000u;
}

class SweepBuilder {
 public:
  explicit SweepBuilder(const References& references)
      : references_(references.items),
        tree_(references.size()),
        right_area_(references.size()),
        goes_right_(references.size()),
        scratch_(references.size()) {}

  BinaryTree build() {
    for (int axis = 0; axis < 3; ++axis) sort_by_centroid(axis);
    const Stage stage{"sweep"};
    if (tree_.empty()) return std::move(tree_);
    split_top_down(
        Range{0, references_.size(), kRoot}, [&](const Range& range) { return split(range); },
        [&](const Range& range) { place_leaf(range); });
    return std::move(tree_);
  }

 private:
  void sort_by_centroid(int axis) {
    const Stage stage{"sort centroids"};
    Array<SortEntry> entries(references_.size());
    parallel_for(entries.size(), kGrain, [&](std::size_t i) {
      entries[i] = {sortable(doubled_centroid(references_[i].box())[axis]), std::uint32_t(i)};
    });
    radix_sort(entries);
    order_[axis] = Array<std::uint32_t>(entries.size());
    parallel_for(entries.size(), kGrain,
                 [&](std::size_t i) { order_[axis][i] = entries[i].value; });
  }

  void place_leaf(const Range& range) {
    tree_.nodes[range.slot] = {{}, order_[0][range.begin], {}, 1};
  }

  std::array<Range, 2> split(const Range& range) {
    Split best;
    for (int axis = 0; axis < 3; ++axis) sweep_axis(range, axis, best);
    partition(range, best);
    const auto pair = std::uint32_t(2 * best.position);
    tree_.nodes[range.slot] = {{}, pair, {}, std::uint32_t(range.count())};
    return {Range{range.begin, best.position, pair}, Range{best.position, range.end, pair + 1}};
  }

  void sweep_axis(const Range& range, int axis, Split& best) {
    const Array<std::uint32_t>& order = order_[axis];
    Aabb right = Aabb::empty();
    for (std::size_t i = range.end; i-- > range.begin + 1;) {
      right = merge(right, references_[order[i]].box());
      right_area_[i] = half_area(right);
    }
    Aabb left = Aabb::empty();
    for (std::size_t i = range.begin + 1; i < range.end; ++i) {
      left = merge(left, references_[order[i - 1]].box());
      const std::size_t left_count = i - range.begin, right_count = range.end - i;
      const double cost = double(half_area(left)) * double(left_count) +
                          double(right_area_[i]) * double(right_count);
      const std::size_t imbalance = std::max(left_count, right_count);
      const Split split{cost, axis, i, imbalance};
      if (split.better_than(best)) best = split;
    }
  }

  /// Stable, so that the other axes stay sorted.
  void partition(const Range& range, const Split& split) {
    for (std::size_t i = range.begin; i < range.end; ++i) {
      goes_right_[order_[split.axis][i]] = i >= split.position;
    }
    for (int axis = 0; axis < 3; ++axis) {
      if (axis == split.axis) continue;
      std::size_t left = range.begin, right = split.position;
      for (std::size_t i = range.begin; i < range.end; ++i) {
        const std::uint32_t reference = order_[axis][i];
        scratch_[goes_right_[reference] ? right++ : left++] = reference;
      }
      std::copy(scratch_.begin() + range.begin, scratch_.begin() + range.end,
                order_[axis].begin() + range.begin);
    }
  }

  const Array<Reference>& references_;
  BinaryTree tree_;
  std::array<Array<std::uint32_t>, 3> order_;
  Array<float> right_area_;
  Array<std::uint8_t> goes_right_;
  Array<std::uint32_t> scratch_;
};

}  // namespace

BinaryTree build_sweep(const References& references) {
  BinaryTree tree = SweepBuilder(references).build();
  refit(tree, references);
  return tree;
}

}  // namespace treelet
