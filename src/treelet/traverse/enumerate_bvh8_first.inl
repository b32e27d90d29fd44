// The first crossings of rays, a few each. Part of enumerate_bvh8_kernel.inl.

namespace treelet::TREELET_ISA {
namespace {

/// A limit that hits make smaller.
struct ShrinkingLimit {
  float t_max;

  TREELET_INLINE explicit ShrinkingLimit(const Ray& ray) : t_max(ray.t_max) {}
  TREELET_INLINE float t_limit() const { return t_max; }
};

/// A ray that looks for its first crossings, as Wave wants it.
struct FirstHitsRay : CrossingRay<ShrinkingLimit> {
  using Base = CrossingRay<ShrinkingLimit>;
  using Base::number, Base::shear, Base::visitor;

  TREELET_INLINE bool set_up(const Ray* ray, const SceneLanes& scene, FirstHits* answer) {
    source_ = ray;
    found_ = answer;
    return Base::begin(*ray, scene);
  }
  TREELET_INLINE void count_node() {}
  TREELET_INLINE bool finish(const FirstHits*) { return true; }

  TREELET_INLINE bool visit_leaf(const TriangleBlock* blocks, unsigned count,
                                 const FaceFilter& filter) {
    push_crossings(*this, *source_, blocks, count, filter, *found_);
    const float last =
        found_->count == found_->most ? found_->hits[found_->most - 1].t : visitor.t_max;
    if (last < visitor.t_max) {
      visitor.t_max = last;
      Base::update_limit();
    }
    return false;
  }

 private:
  const Ray* source_;
  FirstHits* found_;
};

struct FirstHitsQuery {
  using Answer = FirstHits;
  static constexpr bool kAny = false;
};

void find_first(const Bvh8View& bvh, const Ray* rays, std::uint32_t count, FirstHits* answers,
                const WaveStacks::View& stacks) {
  for (std::uint32_t begin = 0; begin < count; begin += kPartRays) {
    RayNumbers numbers, rejected;
    numbers.add(0, count - begin < kPartRays ? count - begin : kPartRays);
    Wave<FirstHitsQuery, FirstHitsRay, kWaveRays>(bvh, rays + begin, numbers, answers + begin,
                                                  rejected)
        .run(stacks);
  }
}

}  // namespace
}  // namespace treelet::TREELET_ISA
