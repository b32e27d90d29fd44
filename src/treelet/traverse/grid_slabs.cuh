#pragma once

#include <cstdint>
#include <cstring>

#include <treelet/layout/cwbvh.h>
#include <treelet/core/launch.cuh>
#include <treelet/traverse/fused_slabs.cuh>

namespace treelet::cuda {

/// Four bytes that lie side by side.
__device__ inline std::uint32_t word_at(const std::uint8_t* bytes) {
  std::uint32_t word;
  std::memcpy(&word, bytes, sizeof(word));
  return word;
}

__device__ inline std::uint32_t byte_of(std::uint32_t word, int i) { return word >> 8 * i & 0xff; }

/// Where the ray enters and leaves the slabs of four children: their planes' numbers, a byte each.
struct PlaneWords {
  std::uint32_t near_plane[3], far_plane[3];

  __device__ PlaneWords(const FusedSlabs& slabs, const CwbvhNode& node, int first_child) {
    for (int axis = 0; axis < 3; ++axis) {
      const std::uint32_t lower = word_at(&node.lower[axis][first_child]);
      const std::uint32_t upper = word_at(&node.upper[axis][first_child]);
      const bool down = slabs.points_down(axis);
      near_plane[axis] = down ? upper : lower;
      far_plane[axis] = down ? lower : upper;
    }
  }
};

/// FusedSlabs over the grid of a node: plane q is at
///
///     t = (2^15 + q) * step + offset      step = cell * inverse
///                                         offset = origin * inverse + the ray's - 2^15 step
///
/// with the grid's origin and the ray's near or far offset. A permutation of bytes makes 2^15 + q
/// of q; a conversion would be an instruction more for each of 48 planes.
///
/// Planes bound the children's boxes exactly. Beside those of FusedSlabs there are these roundings:
/// u R each for adding the ray's offset, the widening and 2^15 steps, and with the last u 2^15 =
/// 2^-9 of a step. The 16u R of traverse/ray_box.h, of which 9u were used, have room for the first
/// three, also where planes lie a cell, less than R / 60, outside of the scene. For the last,
/// planes are moved apart by 2^-8 of a step.
class GridSlabs {
 public:
  __device__ GridSlabs(const FusedSlabs& slabs, const CwbvhNode& node) {
    constexpr float kWidening = 0x1p-8f;
    for (int axis = 0; axis < 3; ++axis) {
      const float cell = __uint_as_float(std::uint32_t(node.exponent[axis]) << 23);
      step_[axis] = cell * slabs.inverse[axis];
      const float near_t =
          __fmaf_rn(node.origin[axis], slabs.inverse[axis], slabs.near_offset[axis]);
      const float far_t = __fmaf_rn(node.origin[axis], slabs.inverse[axis], slabs.far_offset[axis]);
      const float widening = fabsf(step_[axis]);
      near_offset_[axis] = __fmaf_rn(-kFirst, step_[axis], __fmaf_rn(-kWidening, widening, near_t));
      far_offset_[axis] = __fmaf_rn(-kFirst, step_[axis], __fmaf_rn(kWidening, widening, far_t));
    }
  }

  /// Of child i of the four.
  __device__ BoxSpan intersect(const FusedSlabs& slabs, const PlaneWords& planes, int i,
                               float limit) const {
    float near_t[3], far_t[3];
    for (int axis = 0; axis < 3; ++axis) {
      near_t[axis] = __fmaf_rn(plane(planes.near_plane[axis], i), step_[axis], near_offset_[axis]);
      far_t[axis] = __fmaf_rn(plane(planes.far_plane[axis], i), step_[axis], far_offset_[axis]);
    }
    return slabs.clip(near_t, far_t, limit);
  }

 private:
  static constexpr float kFirst = 0x1p15f;

  /// 2^15 + byte i: the byte in the middle of the float's fraction, whose bit 8 counts for 1.
  __device__ static float plane(std::uint32_t word, int i) {
    constexpr std::uint32_t kBits = 0x47000000;  // of 2^15
    return __uint_as_float(__byte_perm(word, kBits, 0x7604 | i << 4));
  }

  float step_[3], near_offset_[3], far_offset_[3];
};

}  // namespace treelet::cuda
