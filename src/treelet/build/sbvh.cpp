#include <treelet/build/sbvh.h>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <treelet/build/spaced_tree.h>
#include <treelet/build/split_planes.h>
#include <treelet/core/parallel.h>
#include <treelet/core/stage.h>
#include <treelet/primitive/split_steps.h>
#include <treelet/tree/refit.h>

// References live in one long array. A node owns places [begin, limit) of it, of which its
// references fill the first ones; what is left is its share of the budget:
//
//     node   |references.........|free...|
//     left   |refs.....|free|              the free places go to the halves by their references
//     right                 |refs......|free|
//
// At the end places without a reference are left out (build/spaced_tree.h).

namespace treelet {
namespace {

constexpr std::size_t kSerialReferences = 4096;

struct Range {
  std::uint32_t begin = 0, end = 0, limit = 0;
  std::uint32_t slot = kRoot;
  bool may_split = true;  ///< space

  std::uint32_t count() const { return end - begin; }
  std::uint32_t spare() const { return limit - end; }
};

/// The halves of a range, to be laid out.
struct Halves {
  std::vector<Reference> left, right;

  void clear() {
    left.clear();
    right.clear();
  }
  std::size_t count() const { return left.size() + right.size(); }
  bool are_both() const { return !left.empty() && !right.empty(); }
};

class SbvhBuilder {
 public:
  SbvhBuilder(const References& references, const Mesh& mesh, const SbvhConfig& config)
      : source_{mesh, power_of_two(-references.scale_exponent)},
        config_(config),
        least_overlap_(config.scene_overlap * half_area(references.bounds)),
        count_(std::uint32_t(references.size())),
        spaced_(capacity(references.size(), config.budget)) {
    parallel_for(count_, kSerialReferences, [&](std::size_t i) {
      const Reference& item = references.items[i];
      spaced_.items[i] =
          references.may_repeat_faces ? item : with_box(item, triangle(item).bounds());
    });
  }

  void run() {
    std::vector<Range> level{{0, count_, std::uint32_t(spaced_.items.size()), kRoot, true}};
    while (!level.empty()) level = process_level(level);
  }

  BinaryTree finish(References& references) const {
    BinaryTree tree = spaced_.close_gaps(references);
    references.may_repeat_faces = references.may_repeat_faces || references.size() > count_;
    refit(tree, references);
    return tree;
  }

 private:
  /// Its box holds it; that of a reference that nobody has split is rounded to the nearest floats.
  ExactTriangle triangle(const Reference& reference) const {
    return {source_.mesh.triangle(reference.face), source_.scale};
  }

  static std::size_t capacity(std::size_t count, float budget) {
    const double most = double(count) * (1.0 + double(budget) / 100.0);
    return std::size_t(std::min(most, double(kMaxFaces)));
  }

  /// Small ranges are finished, large ones split once: the children make the next level.
  std::vector<Range> process_level(const std::vector<Range>& level) {
    std::vector<std::array<Range, 2>> children(level.size());
    parallel_for(level.size(), 1, [&](std::size_t i) {
      Halves halves;
      if (level[i].count() <= kSerialReferences) {
        finish_range(level[i], halves);
      } else {
        children[i] = split(level[i], halves);
      }
    });
    std::vector<Range> next;
    for (const auto& pair : children) {
      if (pair[0].count() > 0) next.insert(next.end(), pair.begin(), pair.end());
    }
    return next;
  }

  void finish_range(const Range& range, Halves& halves) {
    std::vector<Range> stack{range};
    while (!stack.empty()) {
      const Range top = stack.back();
      stack.pop_back();
      if (top.count() == 1) {
        spaced_.set_leaf(top.slot, top.begin, top.limit);
        continue;
      }
      const std::array<Range, 2> children = split(top, halves);
      stack.push_back(children[1]);
      stack.push_back(children[0]);
    }
  }

  std::array<Range, 2> split(const Range& range, Halves& halves) {
    const std::span<const Reference> references(&spaced_.items[range.begin], range.count());
    const ObjectSplit object = find_object_split(references);
    halves.clear();
    const Aabb box = bound(references);
    bool may_split = range.may_split && range.spare() > 0;
    if (may_split && overlaps(object, box)) {
      const SpatialSplit spatial = find_spatial_split(references, box, source_);
      may_split = !is_leaf_cheaper(box, range.count(), std::min(object.cost, spatial.cost));
      if (may_split && spatial.cost < object.cost) part_space(references, spatial, halves);
      if (halves.count() > range.count() + range.spare()) halves.clear();
    }
    if (!halves.are_both()) part_objects(references, object, halves);
    return lay_out(range, halves, may_split);
  }

  static Aabb bound(std::span<const Reference> references) {
    Aabb box = Aabb::empty();
    for (const Reference& reference : references) box = merge(box, reference.box());
    return box;
  }

  bool overlaps(const ObjectSplit& split, const Aabb& box) const {
    if (!split.exists()) return true;  // equal centroids: planes may part what objects cannot
    const Aabb shared = overlap(split.left, split.right);
    if (!is_nonempty(shared)) return false;
    return half_area(shared) >= max(least_overlap_, config_.node_overlap * half_area(box));
  }

  bool is_leaf_cheaper(const Aabb& box, std::uint32_t count, float split_cost) const {
    const float area = half_area(box);
    return config_.sah.leaf_cost(area, count) <= config_.sah.internal_cost(area, split_cost);
  }

  /// References across the plane stay whole on one side where that is cheaper [Stich2009 s4.4].
  void part_space(std::span<const Reference> references, const SpatialSplit& split,
                  Halves& halves) const {
    SpatialSplit now = split;
    for (const Reference& reference : references) {
      const ReferenceHalves parts = halve(reference, split.axis, split.plane, source_);
      const bool has_below = is_nonempty(parts.below), has_above = is_nonempty(parts.above);
      if (has_below && has_above) {
        part_across(reference, parts, now, halves);
      } else if (has_above) {
        halves.right.push_back(with_box(reference, parts.above));
      } else {
        halves.left.push_back(has_below ? with_box(reference, parts.below) : reference);
      }
    }
  }

  static void part_across(const Reference& reference, const ReferenceHalves& parts,
                          SpatialSplit& now, Halves& halves) {
    const float left_area = half_area(now.left), right_area = half_area(now.right);
    const float left_count = float(now.left_count), right_count = float(now.right_count);
    const Aabb wider_left = merge(now.left, reference.box());
    const Aabb wider_right = merge(now.right, reference.box());
    const float both = left_area * left_count + right_area * right_count;
    const float only_left = half_area(wider_left) * left_count + right_area * (right_count - 1);
    const float only_right = left_area * (left_count - 1) + half_area(wider_right) * right_count;
    if (both <= only_left && both <= only_right) {
      halves.left.push_back(with_box(reference, parts.below));
      halves.right.push_back(with_box(reference, parts.above));
    } else if (only_left <= only_right) {
      halves.left.push_back(reference);
      now.left = wider_left;
      now.right_count -= now.right_count > 1;  // counts of planes are rough
    } else {
      halves.right.push_back(reference);
      now.right = wider_right;
      now.left_count -= now.left_count > 1;
    }
  }

  static Reference with_box(const Reference& reference, const Aabb& box) {
    return {box.lower, reference.face, box.upper, reference.padding};
  }

  /// In the middle of their order where all centroids are equal.
  static void part_objects(std::span<const Reference> references, const ObjectSplit& split,
                           Halves& halves) {
    halves.clear();
    if (split.exists()) {
      for (const Reference& reference : references) {
        (split.goes_left(reference) ? halves.left : halves.right).push_back(reference);
      }
    } else {
      const auto middle = references.begin() + std::ptrdiff_t(references.size() / 2);
      halves.left.assign(references.begin(), middle);
      halves.right.assign(middle, references.end());
    }
  }

  std::array<Range, 2> lay_out(const Range& range, const Halves& halves, bool may_split) {
    const std::uint32_t left = std::uint32_t(halves.left.size());
    const std::uint32_t right = std::uint32_t(halves.right.size());
    const std::uint64_t spare = range.limit - range.begin - left - right;
    const std::uint32_t left_spare = std::uint32_t(spare * left / (left + right));
    const std::uint32_t right_begin = range.begin + left + left_spare;
    std::copy(halves.left.begin(), halves.left.end(), &spaced_.items[range.begin]);
    std::copy(halves.right.begin(), halves.right.end(), &spaced_.items[right_begin]);
    const std::uint32_t left_slot =
        spaced_.set_internal(range.slot, range.begin, range.limit, right_begin);
    return {Range{range.begin, range.begin + left, right_begin, left_slot, may_split},
            Range{right_begin, right_begin + right, range.limit, left_slot + 1, may_split}};
  }

  const SplitSource source_;
  const SbvhConfig& config_;
  const float least_overlap_;
  const std::uint32_t count_;
  SpacedTree spaced_;
};

void check(const SbvhConfig& config) {
  if (config.budget >= 0.0f && config.budget <= 300.0f && config.scene_overlap >= 0.0f &&
      config.node_overlap >= 0.0f) {
    return;
  }
  throw std::invalid_argument("sbvh takes a budget of 0 to 300 percent and overlaps of at least 0");
}

}  // namespace

BinaryTree build_sbvh(References& references, const Mesh& mesh, const SbvhConfig& config) {
  check(config);
  if (references.size() == 0) return {};
  const Stage stage{"build sbvh"};
  SbvhBuilder builder(references, mesh, config);
  references.items = {};
  builder.run();
  return builder.finish(references);
}

}  // namespace treelet
