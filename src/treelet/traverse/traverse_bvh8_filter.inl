// What a filter hides from rays. Part of traverse_bvh8_kernel.inl.

namespace treelet::TREELET_ISA {
namespace {

[[maybe_unused]] TREELET_INLINE Vec3 direction_of(const LaneShear& ray) {
  float direction[3];
  for (int i = 0; i < 3; ++i) {
    direction[ray.row[i] / sizeof(TriangleBlock::vertex[0][0])] = ray.direction[i];
  }
  return {direction[0], direction[1], direction[2]};
}

[[maybe_unused]] TREELET_INLINE bool is_shown(const FaceFilter& filter, const LaneShear& ray,
                                              BlockTriangle triangle) {
  if (!filter.has(triangle.face())) return false;
  return filter.cull == Cull::none || filter.shows(direction_of(ray), triangle.corners());
}

/// Drops the lanes of triangles that the filter hides from the ray.
[[maybe_unused]] TREELET_INLINE void drop_hidden(const FaceFilter& filter, const LaneShear& ray,
                                                 const BlockPair& pair, Verdict& verdict) {
  for (unsigned mask = verdict.possible; mask != 0; mask &= mask - 1) {
    const int i = __builtin_ctz(mask);
    if (!is_shown(filter, ray, pair.triangle(i))) verdict.possible &= ~(1u << i);
  }
  verdict.certain &= verdict.possible;
}

}  // namespace
}  // namespace treelet::TREELET_ISA
