// A ray against the boxes of eight children. Part of traverse_bvh8_kernel.inl.

namespace treelet::TREELET_ISA {
namespace {

constexpr int kWidth = Bvh8Node::kChildren;
constexpr int kBoxLanes = kNativeLanes < kWidth ? kNativeLanes : kWidth;
using BoxLanes = Lanes<kBoxLanes>;

/// RayBox for lanes of boxes. Its padding is moved into the origin, once against the ray's
/// direction and once along it:
///
///     near t = (plane - near_origin) / direction      near_origin = origin + padding
///     far t  = (plane - far_origin) / direction       far_origin  = origin - padding
///
/// Differs from traverse/ray_box.h, which pads t: here rounding the moved origin takes the place of
/// rounding the padded t, and u |origin| twice more padding pays for it.
struct RaySlabs {
  alignas(16) float near_origin[4], far_origin[4];
  alignas(16) float minus_inverse[4];     ///< of the direction
  std::uint32_t near_row[4], far_row[4];  ///< of a node's planes, in bytes
  float t_min, limit;
};

/// Where a ray enters and leaves boxes.
struct BoxSpans {
  BoxLanes enter, leave;
};

TREELET_INLINE BoxLanes load_planes(const Bvh8Node& node, std::uint32_t row, int first) {
  return load<BoxLanes>(offset_by(node.planes[0], row) + first);
}

/// Of the boxes from the `first` one on.
TREELET_INLINE BoxSpans intersect_boxes(const RaySlabs& ray, const Bvh8Node& node, int first) {
  BoxSpans span{broadcast<BoxLanes>(ray.t_min), broadcast<BoxLanes>(ray.limit)};
  for (int axis = 0; axis < 3; ++axis) {
    const BoxLanes near_plane = load_planes(node, ray.near_row[axis], first);
    const BoxLanes far_plane = load_planes(node, ray.far_row[axis], first);
    const BoxLanes minus_inverse = broadcast<BoxLanes>(ray.minus_inverse[axis]);
    const BoxLanes near_origin = broadcast<BoxLanes>(ray.near_origin[axis]);
    const BoxLanes far_origin = broadcast<BoxLanes>(ray.far_origin[axis]);
    span.enter = max(span.enter, (near_origin - near_plane) * minus_inverse);
    span.leave = min(span.leave, (far_origin - far_plane) * minus_inverse);
  }
  return span;
}

/// Children that wait their turn, the next one on top. A key is the float where the ray enters the
/// child as an integer, zero where that is negative; its last bits are the child's place in the
/// node, so that no two of a node are equal.
struct ChildStack {
  std::int32_t* keys;
  std::uint32_t* children;
};

constexpr std::int32_t kPlaceBits = kWidth - 1;

TREELET_INLINE std::int32_t key_of(float enter) {
  const auto bits = __builtin_bit_cast(std::int32_t, enter);
  return bits < 0 ? 0 : bits;
}

/// Drops the children behind a limit, but the first, which is none. Returns how many stay.
TREELET_INLINE std::uint32_t drop_behind(float limit, ChildStack stack, std::uint32_t size) {
  const std::int32_t last = key_of(limit) | kPlaceBits;
  std::uint32_t kept = 1;
  for (std::uint32_t i = 1; i < size; ++i) {
    const std::int32_t key = stack.keys[i];
    stack.keys[kept] = key;
    stack.children[kept] = stack.children[i];
    kept += key <= last;
  }
  return kept;
}

#if defined(__AVX2__)

TREELET_INLINE void store_entries(ChildStack top, IntLanes<8> keys, IntLanes<8> children) {
  store_unaligned(top.keys, keys);
  store_unaligned(top.children, permute(children, keys));
}

/// Puts children that are met on the stack, the nearest on top if `Ordered`, and returns how many.
/// Writes up to eight entries. What meets boxes may be something else than a ray that has an
/// intersect_boxes.
template <bool Ordered, class Slabs>
TREELET_INLINE unsigned push_children(const Slabs& ray, const Bvh8Node& node, ChildStack top) {
  const BoxSpans span = intersect_boxes(ray, node, 0);
  const auto child = load_unaligned<IntLanes<8>>(node.child);
  const IntLanes<8> bits = (IntLanes<8>)span.enter;
  const IntLanes<8> places = {0, 1, 2, 3, 4, 5, 6, 7};
  const IntLanes<8> keys = (max(bits, IntLanes<8>{}) & ~kPlaceBits) | places;
  // A place without a child is met where NaN clips nothing.
  const Packed packed = pack_at_most(keys, span.enter, span.leave, child);
#if defined(__AVX512VL__)
  if (packed.count <= 4) [[likely]] {
    const IntLanes<4> few = first_four(packed.lanes);
    const IntLanes<4> sorted = Ordered ? sort_descending(few) : few;
    store_unaligned(top.keys, sorted);
    store_unaligned(top.children, permute(child, sorted));
    return packed.count;
  }
#endif
  store_entries(top, sort_descending(packed.lanes), child);
  return packed.count;
}

#else

TREELET_INLINE void insert(ChildStack top, unsigned place, std::int32_t key, std::uint32_t child) {
  for (; place != 0 && top.keys[place - 1] < key; --place) {
    top.keys[place] = top.keys[place - 1];
    top.children[place] = top.children[place - 1];
  }
  top.keys[place] = key;
  top.children[place] = child;
}

/// As above.
template <bool Ordered, class Slabs>
TREELET_INLINE unsigned push_children(const Slabs& ray, const Bvh8Node& node, ChildStack top) {
  unsigned count = 0;
  for (int first = 0; first < kWidth; first += kBoxLanes) {
    const BoxSpans span = intersect_boxes(ray, node, first);
    alignas(64) float enter[kBoxLanes];
    store(enter, span.enter);
    for (unsigned met = at_most_mask(span.enter, span.leave); met != 0; met &= met - 1) {
      const int lane = __builtin_ctz(met);
      const WideChild child = node.child[first + lane];
      if (child.is_none()) break;  // met where NaN clips nothing; they come last
      insert(top, count++, (key_of(enter[lane]) & ~kPlaceBits) | (first + lane), child.bits);
    }
  }
  return count;
}

#endif

}  // namespace
}  // namespace treelet::TREELET_ISA
