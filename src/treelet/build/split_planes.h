#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include <treelet/core/box_lanes.h>
#include <treelet/mesh/mesh.h>
#include <treelet/tree/binary_tree.h>

// Where the space of a node is parted best, judged at planes between equal bins of all three axes
// [Stich2009 s4.2]. Costs are areas times pieces, summed over the two halves. A piece is a leaf to
// be: the box of a part of a face, and that face as index.

namespace treelet {

/// Few pieces need few planes: at the bottom of a tree bins would cost more than what they hold.
constexpr int kMaxPlaneBins = 32;
constexpr int plane_bins(std::size_t pieces) {
  return pieces <= 4 ? 4 : pieces <= 16 ? 8 : pieces <= 128 ? 16 : kMaxPlaneBins;
}

/// Equal intervals of all axes of a box, one axis a lane.
class PlaneGrid {
 public:
  using Floats = BoxLanes::Floats;
  using Ints = BoxLanes::Ints;

  PlaneGrid(const BoxLanes& box, int bins);

  int bins() const { return bins_; }
  bool can_part(int axis) const { return scale_[axis] > 0.0f; }
  /// What lies outside of the box belongs to the first or last bin.
  Ints of(Floats point) const {
    const Floats bin = BoxLanes::max(Floats{}, (point - lower_) * scale_);
    return __builtin_convertvector(BoxLanes::min(Floats{} + float(bins_ - 1), bin), Ints);
  }
  /// Between bin - 1 and bin.
  float plane(int axis, int bin) const { return lower_[axis] + float(bin) * width_[axis]; }
  /// Of all axes.
  Floats planes(Ints bins) const { return lower_ + __builtin_convertvector(bins, Floats) * width_; }

 private:
  Floats lower_, width_{}, scale_{};
  int bins_;
};

/// What lies below the plane goes to the left; pieces across it go to both sides.
struct SpatialSplit {
  float cost = std::numeric_limits<float>::infinity();
  int axis = 0;
  float plane = 0.0f;
  BoxLanes left = BoxLanes::empty(), right = BoxLanes::empty();
  std::uint32_t left_count = 0, right_count = 0;

  bool exists() const { return left_count > 0; }
};

/// Reads triangles in build space.
struct SplitSource {
  const Mesh& mesh;
  double scale;
};

/// `box` is that of the pieces. Many of them are looked at in parallel.
SpatialSplit find_spatial_split(std::span<const BinaryNode> pieces, const BoxLanes& box,
                                const SplitSource& source);

/// What a plane across a piece leaves of it on both sides; a side may be empty.
struct PieceHalves {
  Aabb below, above;
};
PieceHalves halve(const BinaryNode& piece, int axis, float plane, const SplitSource& source);

}  // namespace treelet
