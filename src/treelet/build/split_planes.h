#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include <treelet/mesh/mesh.h>
#include <treelet/primitive/reference.h>

// Where a node of references is parted best, judged at some planes an axis. Costs are areas times
// references, summed over the two halves.

namespace treelet {

/// Equal intervals of an axis. A value beyond the ends belongs to the first or last.
struct Bins {
  static constexpr int kMost = 32;

  float lower = 0.0f;
  float scale = 0.0f;  ///< bins a unit; 0 where there is nothing to part
  int count = 1;

  Bins() = default;
  Bins(float from, float to, int intervals);

  bool can_part() const { return scale > 0.0f; }
  int of(float x) const {
    const float bin = (x - lower) * scale;
    return bin < float(count - 1) ? (bin > 0.0f ? int(bin) : 0) : count - 1;
  }
  /// Between bin - 1 and bin.
  float plane(int bin) const { return lower + float(bin) / scale; }
};

/// Few references need few planes: at the bottom of a tree bins would cost more than what they
/// hold.
constexpr int bin_count(std::size_t references) {
  return references <= 4 ? 4 : references <= 16 ? 8 : references <= 128 ? 16 : Bins::kMost;
}

constexpr float kNoSplit = std::numeric_limits<float>::infinity();

/// References whose doubled centroid lies in a bin before `bin` go to the left.
struct ObjectSplit {
  float cost = kNoSplit;
  int axis = 0, bin = 0;
  Bins bins;
  Aabb left = Aabb::empty(), right = Aabb::empty();

  bool exists() const { return cost < kNoSplit; }
  bool goes_left(const Reference& reference) const {
    return bins.of(doubled_centroid(reference.box())[axis]) < bin;
  }
};

/// What lies below the plane goes to the left; references across it go to both sides.
struct SpatialSplit {
  float cost = kNoSplit;
  int axis = 0;
  float plane = 0.0f;
  Aabb left = Aabb::empty(), right = Aabb::empty();
  std::uint32_t left_count = 0, right_count = 0;

  bool exists() const { return cost < kNoSplit; }
};

/// Reads triangles in build space.
struct SplitSource {
  const Mesh& mesh;
  double scale;
};

/// Exists unless all centroids are equal.
ObjectSplit find_object_split(std::span<const Reference> references);

/// `box` is that of the references.
SpatialSplit find_spatial_split(std::span<const Reference> references, const Aabb& box,
                                const SplitSource& source);

/// What a plane across a reference leaves of it on both sides; a side may be empty.
struct ReferenceHalves {
  Aabb below, above;
};
ReferenceHalves halve(const Reference& reference, int axis, float plane, const SplitSource& source);

}  // namespace treelet
