// The triangle nearest to a point in the wide layout: a point against eight boxes, then against the
// triangles of two blocks at once. See core/lanes.inl for how this is included and what it must not
// call.

#include <treelet/query/nearest_bvh8.h>
#include <treelet/traverse/ray_triangle.h>
#include <treelet/core/lanes.inl>
#include <treelet/traverse/traverse_bvh8_blocks.inl>
#include <treelet/traverse/traverse_bvh8_boxes.inl>

// Compiled with lanes, so after what quietens warnings of them.
#include <treelet/query/point_box_steps.h>
#include <treelet/query/point_filter_steps.h>
#include <treelet/query/point_triangle_steps.h>

namespace treelet::TREELET_ISA {
namespace {

struct LaneMath {
  using Number = Doubles;
  static TREELET_INLINE Doubles multiply_add(Doubles a, Doubles b, Doubles c) {
#if defined(__FMA__)
    return (Doubles)_mm256_fmadd_pd((__m256d)a, (__m256d)b, (__m256d)c);
#else
    Doubles result;
    for (int i = 0; i < 4; ++i) result[i] = __builtin_fma(a[i], b[i], c[i]);
    return result;
#endif
  }
  template <class Mask>
  static TREELET_INLINE Doubles select(Mask mask, Doubles yes, Doubles no) {
    return mask ? yes : no;
  }
};

struct FilterMath {
  using Number = TriangleLanes;
  static TREELET_INLINE TriangleLanes of(float x) { return broadcast<TriangleLanes>(x); }
  static TREELET_INLINE TriangleLanes min(TriangleLanes a, TriangleLanes b) {
    return TREELET_ISA::min(a, b);
  }
  static TREELET_INLINE TriangleLanes max(TriangleLanes a, TriangleLanes b) {
    return TREELET_ISA::max(a, b);
  }
  static TREELET_INLINE TriangleLanes magnitude(TriangleLanes x) {
    return TREELET_ISA::magnitude(x);
  }
};

/// A point on its way through the tree.
struct PointSlabs {
  PointInScene placed;
  float limit;         ///< on the excess of boxes
  float filter_limit;  ///< on squared distances of triangles
};

/// excess() of query/point_box_steps.h for lanes of boxes.
template <class L>
TREELET_INLINE L add_excess(const PointSlabs& slabs, int axis, L lower, L upper, L sum) {
  const L point = broadcast<L>(slabs.placed.point[axis]);
  const L e = max(max(lower - point, point - upper), L{}) * broadcast<L>(slabs.placed.scale);
  return sum + e * (e + broadcast<L>(slabs.placed.twice_gap[axis]));
}

/// "Enters" a box at its excess.
TREELET_INLINE BoxSpans intersect_boxes(const PointSlabs& slabs, const Bvh8Node& node, int first) {
  BoxSpans span{BoxLanes{}, broadcast<BoxLanes>(slabs.limit)};
  for (int axis = 0; axis < 3; ++axis) {
    const auto lower = load<BoxLanes>(node.planes[axis] + first);
    const auto upper = load<BoxLanes>(node.planes[axis + 3] + first);
    span.enter = add_excess(slabs, axis, lower, upper, span.enter);
  }
  return span;
}

/// The triangles of two blocks.
struct TrianglePair {
  point_steps::Vector<TriangleLanes> corner[3];

  TREELET_INLINE explicit TrianglePair(const BlockPair& blocks) {
    constexpr std::uint32_t kRow = sizeof(TriangleBlock::vertex[0][0]);
    for (int i = 0; i < 3; ++i) {
      corner[i] = {blocks.coordinates(i, 0), blocks.coordinates(i, kRow),
                   blocks.coordinates(i, 2 * kRow)};
    }
  }

  /// Bit i: the box of triangle i does not rule it out.
  TREELET_INLINE unsigned with_near_boxes(const PointSlabs& slabs) const {
    TriangleLanes sum{};
    const auto add = [&](int axis, TriangleLanes a, TriangleLanes b, TriangleLanes c) {
      sum = add_excess(slabs, axis, min(min(a, b), c), max(max(a, b), c), sum);
    };
    add(0, corner[0].x, corner[1].x, corner[2].x);
    add(1, corner[0].y, corner[1].y, corner[2].y);
    add(2, corner[0].z, corner[1].z, corner[2].z);
    return at_most_mask(sum, broadcast<TriangleLanes>(slabs.limit));
  }

  /// Bit i: triangle i itself is not ruled out.
  TREELET_INLINE unsigned not_beyond(Vec3 point, const PointSlabs& slabs) const {
    const auto splat = [](float x) { return broadcast<TriangleLanes>(x); };
    const point_steps::TriangleFilter<FilterMath> filter(
        {splat(point.x), splat(point.y), splat(point.z)}, splat(slabs.placed.scale), corner[0],
        corner[1], corner[2]);
    const auto is_beyond = filter.is_beyond(splat(slabs.filter_limit));
    return less_mask(TriangleLanes{}, is_beyond ? TriangleLanes{} : splat(1.0f));
  }
};

TREELET_INLINE Doubles splat_double(double x) { return x - Doubles{}; }

TREELET_INLINE point_steps::Vector<Doubles> corner_of(const TriangleBlock& block, int corner) {
  const auto coordinate = [&](int axis) {
    return __builtin_convertvector(load<Lanes<4>>(block.vertex[corner][axis]), Doubles);
  };
  return {coordinate(0), coordinate(1), coordinate(2)};
}

class NearestSearch {
 public:
  TREELET_INLINE NearestSearch(const Bvh8View& bvh, const WaveStacks::View& stacks)
      : bvh_(bvh),
        stack_{reinterpret_cast<std::int32_t*>(stacks.memory), stacks.memory + stacks.stride} {}

  /// `guess` may be the nearest triangle's position: one beside it is as good.
  TREELET_INLINE Nearest run(const NearestQuery& query, std::uint32_t guess) {
    query_ = query.point;
    slabs_.placed =
        point_steps::place_in_scene(&query.point.x, &bvh_.bounds.lower.x, &bvh_.bounds.upper.x);
    nearest_.squared_distance = query.largest;
    nearest_.face = Nearest::kNone;
    set_limit();
    visit_block(guess / TriangleBlock::kTriangles, 0xf);
    visit(WideChild::node(0));
    while (size_ != 0) {
      --size_;
      if ((stack_.keys[size_] & ~kPlaceBits) <= limit_key_) visit({stack_.children[size_]});
    }
    return nearest_;
  }

 private:
  TREELET_INLINE void visit(WideChild child) {
    if (child.is_leaf()) return visit_leaf(child);
    const ChildStack top{stack_.keys + size_, stack_.children + size_};
    size_ += push_children<true>(slabs_, bvh_.nodes[child.node()], top);
  }

  TREELET_INLINE void visit_leaf(WideChild child) {
    const TriangleBlock* const blocks = bvh_.blocks + child.first_block();
    const unsigned count = child.block_count();
    for (unsigned i = 0; i < count; i += kBlocks) {
      const unsigned second = i + kBlocks <= count ? i + kBlocks - 1 : i;
      const BlockPair pair{blocks + i, blocks + second};
      const TrianglePair triangles(pair);
      unsigned lanes = triangles.with_near_boxes(slabs_) & pair.used_lanes();
      if (lanes == 0) continue;
      lanes &= triangles.not_beyond(query_, slabs_);
      if ((lanes & 0xf) != 0) visit_block(child.first_block() + i, lanes & 0xf);
      if (lanes >> 4 != 0) visit_block(child.first_block() + second, lanes >> 4);
    }
  }

  TREELET_INLINE void visit_block(std::uint32_t index, unsigned lanes) {
    const TriangleBlock& block = bvh_.blocks[index];
    const point_steps::Vector<Doubles> point{splat_double(query_.x), splat_double(query_.y),
                                             splat_double(query_.z)};
    const point_steps::TriangleView<LaneMath> view(point, corner_of(block, 0), corner_of(block, 1),
                                                   corner_of(block, 2));
    const Doubles squares = view.squared_distance();
    lanes &= sign_mask(squares <= splat_double(nearest_.squared_distance));
    for (; lanes != 0; lanes &= lanes - 1) {
      const unsigned i = unsigned(__builtin_ctz(lanes));
      consider(block, index * TriangleBlock::kTriangles + i, i, squares[i]);
    }
  }

  TREELET_INLINE void consider(const TriangleBlock& block, std::uint32_t position, unsigned lane,
                               double square) {
    const bool is_nearer = square < nearest_.squared_distance;
    const std::uint32_t face = block.face[lane];
    const bool is_as_near = square == nearest_.squared_distance && face < nearest_.face;
    if (!(is_nearer || is_as_near) || face == TriangleBlock::kNoFace) return;
    if (is_hidden(block, lane)) return;
    nearest_.squared_distance = square;
    nearest_.face = face;
    nearest_.position = position;
    if (is_nearer) set_limit();
  }

  /// point_steps::is_hidden.
  static TREELET_INLINE bool is_hidden(const TriangleBlock& block, unsigned lane) {
    bool is_equal = true;
    for (int axis = 0; axis < 3; ++axis) {
      is_equal &= block.vertex[1][axis][lane] == block.vertex[2][axis][lane];
    }
    return is_equal;
  }

  TREELET_INLINE void set_limit() {
    slabs_.limit = point_steps::excess_limit(slabs_.placed, nearest_.squared_distance);
    slabs_.filter_limit = point_steps::filter_limit(slabs_.placed, nearest_.squared_distance);
    limit_key_ = key_of(slabs_.limit);
  }

  const Bvh8View& bvh_;
  const ChildStack stack_;
  Vec3 query_;
  PointSlabs slabs_;
  Nearest nearest_;
  std::int32_t limit_key_;
  std::uint32_t size_ = 0;
};

void search(const Bvh8View& bvh, const NearestQuery* queries, std::size_t count, Nearest* answers,
            const WaveStacks::View& stacks) {
  NearestSearch search(bvh, stacks);
  std::uint32_t guess = 0;
  for (std::size_t i = 0; i < count; ++i) {
    answers[i] = search.run(queries[i], guess);
    if (answers[i].face != Nearest::kNone) guess = answers[i].position;
  }
}

}  // namespace

Bvh8NearestSearch bvh8_nearest_search() { return search; }

}  // namespace treelet::TREELET_ISA
