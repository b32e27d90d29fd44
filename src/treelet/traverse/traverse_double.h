#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <treelet/core/double_ray.h>
#include <treelet/core/isa.h>
#include <treelet/layout/double_bvh8.h>
#include <treelet/traverse/double_ray_setup.h>
#include <treelet/traverse/double_triangle.h>

namespace treelet {

/// The tree as kernels see it, and the stack of a thread: they call nothing of Array's.
struct DoubleBvh8View {
  const Bvh8Node* nodes;
  const DoubleBlock* blocks;
  std::int32_t* keys;
  std::uint32_t* children;
};

/// Queries of one prepared ray, as compiled for one instruction set. The tree must have nodes. The
/// answers are the same bits for all.
struct DoubleTracer {
  template <class Answer>
  using Trace = void (*)(const DoubleBvh8View& bvh, DoubleRaySetup& ray, Answer& answer);
  Trace<DoubleHit>
      closest;      ///< smallest t, of equal t the smaller face; the answer is a miss before
  Trace<bool> any;  ///< false before
  Trace<std::int64_t> count;          ///< of crossings; zero before
  Trace<std::vector<DoubleHit>> all;  ///< crossings in any order, added
};
DoubleTracer double_tracer(Isa isa);

/// Queries of one ray after the other, for one thread.
class DoubleRayTracer {
 public:
  explicit DoubleRayTracer(const DoubleBvh8& bvh);

  DoubleHit closest(const DoubleRay& ray);
  bool any(const DoubleRay& ray);
  std::int64_t count(const DoubleRay& ray);
  /// Sorted by (t, face).
  void list(const DoubleRay& ray, std::vector<DoubleHit>& hits);

 private:
  template <class Answer>
  void trace(DoubleTracer::Trace<Answer> query, const DoubleRay& ray, Answer& answer);

  const DoubleBvh8& bvh_;
  std::vector<std::int32_t> keys_;
  std::vector<std::uint32_t> children_;
  const DoubleTracer tracer_;
};

/// What kernels call where lanes cannot decide.
bool meets(const DoubleRaySetup& ray, const DoubleBlock& block, unsigned lane);
bool crosses(const DoubleRaySetup& ray, const DoubleBlock& block, unsigned lane);
double place_exactly(const DoubleRaySetup& ray, const DoubleBlock& block, unsigned lane,
                     Place place);
void add_hit(std::vector<DoubleHit>& hits, const DoubleHit& hit);

}  // namespace treelet
