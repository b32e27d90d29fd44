// A packet's rays against a triangle, and what they have hit. Part of traverse_bvh8_kernel.inl.

namespace treelet::TREELET_ISA {
namespace {

/// Rays that are tested in doubles at a time.
#if defined(__AVX512F__)
using RayDoubles = EightDoubles;
#else
using RayDoubles = Doubles;
#endif
constexpr int kExactRays = sizeof(RayDoubles) / sizeof(double);
using ExactLanes = Lanes<kExactRays>;
using ExactBits = IntLanes<kExactRays>;

/// Some lanes out of all, and back.
template <class Part, class All>
TREELET_INLINE Part part_of(const All& all, int first) {
  return load_unaligned<Part>(reinterpret_cast<const char*>(&all) + first * sizeof(float));
}
template <class Part, class All>
TREELET_INLINE void put_part(All& all, int first, Part lanes) {
  store_unaligned(reinterpret_cast<char*>(&all) + first * sizeof(float), lanes);
}

TREELET_INLINE LaneVertex<RayLanes> shear(const PacketShear& rays, BlockTriangle triangle,
                                          int corner) {
  const auto coordinate = [&](int i) {
    return broadcast<RayLanes>(triangle.coordinate(corner, rays.row[i])) - rays.origin[i];
  };
  const RayLanes z = coordinate(2);
  return {coordinate(0) - rays.shear_x * z, coordinate(1) - rays.shear_y * z, z};
}

TREELET_INLINE Verdict test_rays(const PacketShear& rays, BlockTriangle triangle, unsigned lanes) {
  return test_lanes<RayLanes>(shear(rays, triangle, 0), shear(rays, triangle, 1),
                              shear(rays, triangle, 2),
                              {rays.direction[2], rays.z_min, rays.z_max, rays.z_slack}, lanes);
}

/// Some lanes as doubles.
TREELET_INLINE RayDoubles widen(const RayLanes& lanes, int first) {
  return __builtin_convertvector(part_of<ExactLanes>(lanes, first), RayDoubles);
}

/// Of the rays from the `first` one on.
TREELET_INLINE DoubleHits<RayDoubles> intersect_in_doubles(const PacketShear& rays,
                                                           BlockTriangle triangle, int first) {
  RayDoubles origin[3], direction[3];
  for (int i = 0; i < 3; ++i) {
    origin[i] = widen(rays.origin[i], first);
    direction[i] = widen(rays.direction[i], first);
  }
  const auto vertex = [&](int corner) {
    RayDoubles to[3];
    for (int i = 0; i < 3; ++i) {
      to[i] = splat<RayDoubles>(triangle.coordinate(corner, rays.row[i])) - origin[i];
    }
    const auto& [x, y, z] = to;
    return LaneVertex<RayDoubles>{x * direction[2] - z * direction[0],
                                  y * direction[2] - z * direction[1], z};
  };
  return intersect_in_doubles(vertex(0), vertex(1), vertex(2), direction[2]);
}

/// One of the rays, as single rays have it.
TREELET_INLINE LaneShear shear_of(const PacketShear& rays, int ray) {
  LaneShear shear{};
  for (int i = 0; i < 3; ++i) {
    shear.origin[i] = rays.origin[i][ray];
    shear.direction[i] = rays.direction[i][ray];
    shear.row[i] = rays.row[i];
  }
  return shear;
}

/// Drops the rays that see a side of the triangle, or a face, that the filter hides.
[[maybe_unused]] TREELET_INLINE void drop_hidden(const FaceFilter& filter, const PacketShear& rays,
                                                 BlockTriangle triangle, Verdict& verdict) {
  for (unsigned mask = verdict.possible; mask != 0; mask &= mask - 1) {
    const int i = __builtin_ctz(mask);
    if (!is_shown(filter, shear_of(rays, i), triangle)) verdict.possible &= ~(1u << i);
  }
  verdict.certain &= verdict.possible;
}

TREELET_INLINE ExactBits lanes_of(unsigned bits) {
  ExactBits place;
  for (int i = 0; i < kExactRays; ++i) place[i] = 1 << i;
  return (place & int(bits)) != 0;
}

/// Hits of the triangle `face` with rays from the `first` one on; `rays` has bits of those.
struct PacketCandidates {
  int first;
  unsigned rays;
  std::int32_t face;
  ExactLanes t, u, v;
};

/// ClosestHit for each ray of a packet.
struct PacketClosest {
  RayLanes t_min, limit, u{}, v{};
  RayBits face = RayBits{} - 1;

  TREELET_INLINE PacketClosest(RayLanes least, RayLanes most) : t_min(least), limit(most) {}

  TREELET_INLINE unsigned open() const { return kAllRays; }
  TREELET_INLINE void accept(unsigned) {}

  /// True when that makes a limit smaller.
  TREELET_INLINE bool visit(const PacketCandidates& hits) {
    constexpr float inf = std::numeric_limits<float>::infinity();
    const auto old = part_of<ExactLanes>(limit, hits.first);
    const auto old_face = part_of<ExactBits>(face, hits.first);
    const ExactBits smaller = (old_face < 0) | (old_face > hits.face);  // than -1, no face, all are
    const ExactBits closer = lanes_of(hits.rays) &
                             (hits.t >= part_of<ExactLanes>(t_min, hits.first)) & (hits.t < inf) &
                             ((hits.t < old) | ((hits.t == old) & smaller));
    put_part(limit, hits.first, closer ? hits.t : old);
    put_part(face, hits.first, closer ? ExactBits{} + hits.face : old_face);
    put_part(u, hits.first, closer ? hits.u : part_of<ExactLanes>(u, hits.first));
    put_part(v, hits.first, closer ? hits.v : part_of<ExactLanes>(v, hits.first));
    return differ_mask((ExactLanes)closer, 0) != 0;
  }

  TREELET_INLINE void write(Hit* hits) const {
    constexpr float inf = std::numeric_limits<float>::infinity();
    const RayLanes t = face < 0 ? broadcast<RayLanes>(inf) : limit;
    for (int i = 0; i < kPacketRays; i += 4) {
      Coordinates rows[4] = {part_of<Coordinates>(t, i), part_of<Coordinates>(face, i),
                             part_of<Coordinates>(u, i), part_of<Coordinates>(v, i)};
      transpose(rows);
      for (int k = 0; k < 4; ++k) store_unaligned(hits + i + k, rows[k]);
    }
  }
};

/// AnyHit for each ray of a packet.
struct PacketAny {
  RayLanes t_min, limit;
  unsigned found = 0;

  TREELET_INLINE PacketAny(RayLanes least, RayLanes most) : t_min(least), limit(most) {}

  TREELET_INLINE unsigned open() const { return ~found & kAllRays; }
  TREELET_INLINE void accept(unsigned rays) { found |= rays; }

  TREELET_INLINE bool visit(const PacketCandidates& hits) {
    constexpr float inf = std::numeric_limits<float>::infinity();
    const unsigned met = at_most_mask(part_of<ExactLanes>(t_min, hits.first), hits.t) &
                         at_most_mask(hits.t, part_of<ExactLanes>(limit, hits.first)) &
                         less_mask(hits.t, broadcast<ExactLanes>(inf));
    found |= (met & hits.rays) << hits.first;
    return false;
  }

  TREELET_INLINE void write(bool* occluded) const {
    for (int i = 0; i < kPacketRays; ++i) occluded[i] = (found >> i & 1) != 0;
  }
};

}  // namespace
}  // namespace treelet::TREELET_ISA
