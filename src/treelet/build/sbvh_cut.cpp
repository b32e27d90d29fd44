#include <treelet/build/sbvh_cut.h>

#include <algorithm>

#include <treelet/build/few_nodes.h>
#include <treelet/primitive/split_steps.h>

namespace treelet::sbvh {
namespace {

int object_bins(std::size_t pieces) { return pieces <= 128 ? 16 : 32; }

BinaryNode with_box(BinaryNode piece, const Aabb& box) {
  piece.set_box(box);
  return piece;
}

void part_across(const BinaryNode& piece, const PieceHalves& parts, SpatialSplit& now,
                 Halves& halves) {
  const float left_area = now.left.half_area(), right_area = now.right.half_area();
  const float left_count = float(now.left_count), right_count = float(now.right_count);
  const BoxLanes whole = BoxLanes::load_box(piece);
  const BoxLanes wider_left = merge(now.left, whole), wider_right = merge(now.right, whole);
  const float both = left_area * left_count + right_area * right_count;
  const float only_left = wider_left.half_area() * left_count + right_area * (right_count - 1);
  const float only_right = left_area * (left_count - 1) + wider_right.half_area() * right_count;
  if (both <= only_left && both <= only_right) {
    halves[0].put(with_box(piece, parts.below));
    halves[1].put(with_box(piece, parts.above));
  } else if (only_left <= only_right) {
    halves[0].put(piece);
    now.left = wider_left;
    now.right_count -= now.right_count > 1;  // counts of planes are rough
  } else {
    halves[1].put(piece);
    now.right = wider_right;
    now.left_count -= now.left_count > 1;
  }
}

}  // namespace

ObjectSplit::ObjectSplit(std::span<const BinaryNode> pieces, const BoxLanes& centroids)
    : grid_(centroids, object_bins(pieces.size())), middle_(pieces.size() / 2) {
  if (!grid_.can_part()) return;
  if (pieces.size() <= kFewNodes) {
    const FewNodesSplit few = split_few_nodes(pieces);
    split_ = few.split;
    few_go_right_ = few.goes_right;
  } else {
    split_ = find_node_split(pieces, grid_);
  }
}

Cutter::Cutter(const SplitSource& source, const SbvhConfig& config, const Aabb& scene)
    : source_(source), config_(config), least_overlap_(config.scene_overlap * half_area(scene)) {}

Cut Cutter::choose(const Range& range, std::span<const BinaryNode> pieces) const {
  Cut cut{.objects = {pieces, range.centroids}, .may_split = range.may_split && range.spare > 0};
  if (!cut.may_split || !overlaps(cut.objects, range.box.half_area())) return cut;
  const SpatialSplit space = find_spatial_split(pieces, range.box, source_);
  const float least = std::min(cut.objects.cost(), space.cost);
  cut.may_split = !is_leaf_cheaper(range, least);
  if (cut.may_split && space.cost < cut.objects.cost()) cut.space = space;
  return cut;
}

void Cutter::part(std::span<const BinaryNode> pieces, std::size_t first, const Cut& cut,
                  Halves& halves) const {
  if (cut.space.exists()) return part_space(pieces, cut.space, halves);
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    halves[cut.objects.goes_right(first + i, pieces[i])].put(pieces[i]);
  }
}

bool Cutter::overlaps(const ObjectSplit& split, float area) const {
  if (!split.exists()) return area >= least_overlap_;  // equal centroids: all of the node
  const Aabb shared = split.overlap().box();
  if (!is_nonempty(shared)) return false;
  return half_area(shared) >= max(least_overlap_, config_.node_overlap * area);
}

bool Cutter::is_leaf_cheaper(const Range& range, float split_cost) const {
  const float area = range.box.half_area();
  return config_.sah.leaf_cost(area, range.pieces) <= config_.sah.internal_cost(area, split_cost);
}

/// Pieces across the plane stay whole on one side where that is cheaper [Stich2009 s4.4].
void Cutter::part_space(std::span<const BinaryNode> pieces, const SpatialSplit& split,
                        Halves& halves) const {
  SpatialSplit now = split;
  for (const BinaryNode& piece : pieces) {
    const PieceHalves parts = halve(piece, split.axis, split.plane, source_);
    const bool has_below = is_nonempty(parts.below), has_above = is_nonempty(parts.above);
    if (has_below && has_above) {
      part_across(piece, parts, now, halves);
    } else if (has_above) {
      halves[1].put(with_box(piece, parts.above));
    } else {
      halves[0].put(has_below ? with_box(piece, parts.below) : piece);
    }
  }
}

}  // namespace treelet::sbvh
