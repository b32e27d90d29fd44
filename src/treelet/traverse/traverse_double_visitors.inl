// What is looked for in blocks that a ray may hit, and where exactly hits are. Part of
// traverse_double_kernel.inl.

namespace treelet::TREELET_ISA {
namespace {

/// Three numbers that a sum of their products never cancels.
struct Size {
  double value;

  friend TREELET_INLINE Size operator+(Size a, Size b) { return {a.value + b.value}; }
  friend TREELET_INLINE Size operator-(Size a, Size b) { return {a.value + b.value}; }
  friend TREELET_INLINE Size operator*(Size a, Size b) { return {a.value * b.value}; }
};

TREELET_INLINE double absolute(double x) { return __builtin_fabs(x); }

/// A vector, and the sizes of its components.
struct LongVector {
  DoubleDouble xyz[3];
  Size sizes[3];

  TREELET_INLINE void set(int axis, DoubleDouble value) {
    xyz[axis] = value;
    sizes[axis] = {absolute(value.high)};
  }
  TREELET_INLINE double size() const { return sizes[0].value + sizes[1].value + sizes[2].value; }
};

/// A triple product, and what rounding can have moved it by: 2^-99 of its size in six operations,
/// and what underflows. Four times that.
struct LongProduct {
  DoubleDouble value;
  double error = 0.0;

  LongProduct() = default;
  TREELET_INLINE LongProduct(const LongVector& a, const LongVector& p, const LongVector& q)
      : value(triple_product(a.xyz, p.xyz, q.xyz)),
        error(0x1p-97 * triple_product(a.sizes, p.sizes, q.sizes).value +
              0x1p-1060 * (a.size() + p.size() + q.size() + 1.0)) {}
};

/// The quotient rounded to nearest; false where that is not certain.
TREELET_INLINE bool divide(const LongProduct& a, const LongProduct& b, double& rounded) {
  constexpr double kLeast = 0x1p-900, kMost = 0x1p900;
  const DoubleDouble quotient = a.value / b.value;
  const double size = absolute(quotient.high);
  const double error =
      2.0 * size * (a.error / absolute(a.value.high) + b.error / absolute(b.value.high) + 0x1p-97);
  rounded = quotient.high;
  const bool is_certain =
      rounded + (quotient.low - error) == rounded && rounded + (quotient.low + error) == rounded;
  return is_certain && size > kLeast && size < kMost && error < size;
}

/// Where the ray's line meets a triangle: place_exactly (traverse/double_triangle.h), most often by
/// numbers of twice the digits.
class Placing {
 public:
  TREELET_INLINE Placing(const DoubleRaySetup& ray, const DoubleBlock& block, unsigned lane)
      : ray_(ray), block_(block), lane_(lane) {
    for (int axis = 0; axis < 3; ++axis) {
      const double corner = block.vertex[0][axis][lane];
      const double origin = ray.ray->origin[axis];
      to_corner_.set(axis, DoubleDouble::difference(corner, origin));
      first_.set(axis, DoubleDouble::difference(block.vertex[1][axis][lane], corner));
      second_.set(axis, DoubleDouble::difference(block.vertex[2][axis][lane], corner));
      direction_.set(axis, {ray.ray->direction[axis], 0.0});
    }
    constexpr double kMost = 0x1p300;  // up to it, products of three do not overflow
    const double size = to_corner_.size() + first_.size() + second_.size() + direction_.size();
    is_moderate_ = size < kMost;
    volume_ = LongProduct(direction_, first_, second_);
  }

  TREELET_INLINE double t() const {
    return divided(LongProduct(to_corner_, first_, second_), Place::t);
  }
  TREELET_INLINE double u() const {
    return divided(LongProduct(to_corner_, direction_, second_), Place::u);
  }
  TREELET_INLINE double v() const {
    return divided(LongProduct(to_corner_, first_, direction_), Place::v);
  }

 private:
  TREELET_INLINE double divided(const LongProduct& numerator, Place place) const {
    double rounded;
    if (is_moderate_ && divide(numerator, volume_, rounded)) return rounded;
    return place_exactly(ray_, block_, lane_, place);
  }

  const DoubleRaySetup& ray_;
  const DoubleBlock& block_;
  const unsigned lane_;
  LongVector to_corner_, first_, second_, direction_;
  LongProduct volume_;
  bool is_moderate_;
};

TREELET_NOINLINE double find_t(const DoubleRaySetup& ray, const DoubleBlock& block, unsigned lane) {
  return Placing(ray, block, lane).t();
}

TREELET_NOINLINE void find_tuv(const DoubleRaySetup& ray, const DoubleBlock& block, unsigned lane,
                               DoubleHit& hit) {
  const Placing placing(ray, block, lane);
  hit.t = placing.t();
  hit.u = placing.u();
  hit.v = placing.v();
}

TREELET_NOINLINE void find_uv(const DoubleRaySetup& ray, const DoubleBlock& block, unsigned lane,
                              DoubleHit& hit) {
  const Placing placing(ray, block, lane);
  hit.u = placing.u();
  hit.v = placing.v();
}

// Each visit says whether the ray is done.

/// Smallest t in the limits; of equal t the smaller face.
class DoubleClosest {
 public:
  static constexpr bool kMovesLimit = true;

  TREELET_INLINE DoubleClosest(const DoubleRaySetup& ray, DoubleHit& hit)
      : hit_(hit), limit_(ray.ray->t_max) {}

  TREELET_INLINE double limit() const { return limit_; }

  TREELET_INLINE bool visit(DoubleRaySetup& ray, const DoubleBlock& block,
                            const DoubleVerdict& verdict) {
    for (unsigned mask = verdict.possible; mask != 0; mask &= mask - 1) {
      const auto lane = unsigned(__builtin_ctz(mask));
      if ((verdict.inside >> lane & 1) == 0 && !meets(ray, block, lane)) continue;
      take(ray, block, lane);
    }
    return false;
  }

  TREELET_INLINE void finish(const DoubleRaySetup& ray) {
    if (block_ != nullptr) find_uv(ray, *block_, lane_, hit_);
  }

 private:
  TREELET_INLINE void take(DoubleRaySetup& ray, const DoubleBlock& block, unsigned lane) {
    const double t = find_t(ray, block, lane);
    const auto face = std::int32_t(block.face[lane]);
    if (!(t >= ray.ray->t_min && t <= limit_ && t < __builtin_inf())) return;
    if (t == hit_.t && face > hit_.face) return;
    limit_ = hit_.t = t;
    hit_.face = face;
    block_ = &block;
    lane_ = lane;
    ray.set_upper_limit(t);
  }

  DoubleHit& hit_;
  double limit_;
  const DoubleBlock* block_ = nullptr;
  unsigned lane_ = 0;
};

/// Of visitors whose limits stay.
class FixedLimit {
 public:
  static constexpr bool kMovesLimit = false;

  TREELET_INLINE void finish(const DoubleRaySetup&) {}

 protected:
  /// Whether t is within the limits, which the caller did not find certain.
  static TREELET_INLINE bool is_within(const DoubleRaySetup& ray, double t) {
    return t >= ray.ray->t_min && t <= ray.ray->t_max;
  }
};

class DoubleAny : public FixedLimit {
 public:
  TREELET_INLINE explicit DoubleAny(bool& found) : found_(found) {}

  TREELET_INLINE bool visit(const DoubleRaySetup& ray, const DoubleBlock& block,
                            const DoubleVerdict& verdict) {
    found_ = (verdict.possible & verdict.inside & verdict.within) != 0;
    for (unsigned mask = verdict.possible; mask != 0 && !found_; mask &= mask - 1) {
      const auto lane = unsigned(__builtin_ctz(mask));
      if ((verdict.inside >> lane & 1) == 0 && !meets(ray, block, lane)) continue;
      const double t = find_t(ray, block, lane);
      found_ = is_within(ray, t) && t < __builtin_inf();
    }
    return found_;
  }

 private:
  bool& found_;
};

class DoubleCount : public FixedLimit {
 public:
  TREELET_INLINE explicit DoubleCount(std::int64_t& count) : count_(count) {}

  TREELET_INLINE bool visit(const DoubleRaySetup& ray, const DoubleBlock& block,
                            const DoubleVerdict& verdict) {
    for (unsigned mask = verdict.possible; mask != 0; mask &= mask - 1) {
      const auto lane = unsigned(__builtin_ctz(mask));
      if ((verdict.inside >> lane & 1) == 0 && !crosses(ray, block, lane)) continue;
      count_ += (verdict.within >> lane & 1) != 0 || is_within(ray, find_t(ray, block, lane));
    }
    return false;
  }

 private:
  std::int64_t& count_;
};

class DoubleList : public FixedLimit {
 public:
  TREELET_INLINE explicit DoubleList(std::vector<DoubleHit>& hits) : hits_(hits) {}

  TREELET_INLINE bool visit(const DoubleRaySetup& ray, const DoubleBlock& block,
                            const DoubleVerdict& verdict) {
    for (unsigned mask = verdict.possible; mask != 0; mask &= mask - 1) {
      const auto lane = unsigned(__builtin_ctz(mask));
      if ((verdict.inside >> lane & 1) == 0 && !crosses(ray, block, lane)) continue;
      DoubleHit hit{.face = std::int32_t(block.face[lane])};
      find_tuv(ray, block, lane, hit);
      if (is_within(ray, hit.t)) add_hit(hits_, hit);
    }
    return false;
  }

 private:
  std::vector<DoubleHit>& hits_;
};

}  // namespace
}  // namespace treelet::TREELET_ISA
