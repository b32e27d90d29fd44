#include <treelet/traverse/grid_slabs.cuh>

#include <gtest/gtest.h>

#include <treelet/traverse/is_traceable.h>
#include <treelet/traverse/visitors.h>
#include <treelet/core/launch.cuh>
#include <treelet/traverse/device_ray.cuh>

#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "cuda/device_input.h"
#include "support/exact_ray.h"
#include "support/grid_cases.h"

namespace treelet::cuda {
namespace {

using test::GridCase;
using test::kStream;

/// What the device's slab tests say of a child: of its exact box, and on the grid.
struct Answer {
  bool box, grid;
};

__device__ Answer ask(const GridCase& c) {
  RayMemory<AnyHit> memory{AnyHit(c.ray)};
  memory.set_up(c.ray, c.scene);
  const FusedSlabs& slabs = memory.state.slabs;
  const float limit = memory.state.limit;
  const GridSlabs grid(slabs, c.node);
  const PlaneWords planes(slabs, c.node, c.slot & 4);
  return {slabs.intersect(c.child, limit).is_hit(),
          grid.intersect(slabs, planes, c.slot & 3, limit).is_hit()};
}

__global__ void ask_all(const GridCase* cases, std::uint32_t count, Answer* answers) {
  const std::uint32_t i = thread_index();
  if (i < count) answers[i] = ask(cases[i]);
}

Array<Answer> answers_to(const std::vector<GridCase>& cases) {
  const DeviceArray<GridCase> asked = test::upload_all(std::span<const GridCase>(cases));
  DeviceArray<Answer> answers(cases.size(), kStream);
  launch(kStream, thread_each(cases.size(), 128), ask_all, asked.data(),
         std::uint32_t(cases.size()), answers.data());
  return download(answers);
}

bool host_meets(const Ray& ray, const Aabb& scene, const Aabb& box) {
  const RayBox slabs(ray, scene);
  return intersect(slabs, box, slabs.lower_limit(ray.t_min), slabs.upper_limit(ray.t_max)).is_hit();
}

std::vector<GridCase> cases_of(float scale, std::size_t count, std::uint64_t seed) {
  test::Random random(seed);
  std::vector<GridCase> cases;
  while (cases.size() < count) {
    const GridCase c = test::random_grid_case(random, scale);
    if (is_traceable(c.ray)) cases.push_back(c);
  }
  return cases;
}

class DeviceSlabs : public testing::TestWithParam<test::Scale> {};

TEST_P(DeviceSlabs, NeverMissABoxThatTheExactRayMeets) {
  const std::vector<GridCase> cases = cases_of(GetParam().factor, 12000, 6);
  const Array<Answer> answers = answers_to(cases);
  int met = 0, missed = 0;
  for (std::size_t i = 0; i < cases.size() && !HasFailure(); ++i) {
    const bool meets = test::exact_meets_box(cases[i].ray, cases[i].child);
    EXPECT_TRUE(answers[i].box || !meets) << "seed 6, case " << i;
    EXPECT_TRUE(answers[i].grid || !meets) << "seed 6, case " << i;
    met += meets;
    missed += !answers[i].grid;
  }
  EXPECT_GT(met, 1000);
  EXPECT_GT(missed, 50);
}

/// The box and so much more on all sides.
Aabb widened(const Aabb& box, Vec3 margin) { return {box.lower - margin, box.upper + margin}; }

/// More than what the device pads in addition to the host: see FusedSlabs and GridSlabs.
Vec3 margin_of(const Aabb& scene) {
  const float size =
      max(max_component(scene.upper), -min(scene.lower.x, min(scene.lower.y, scene.lower.z)));
  const float margin = 0x1p-16f * size;
  return {margin, margin, margin};
}
Vec3 margin_of(const CwbvhNode& node) {
  const auto margin = [&](int axis) { return std::ldexp(0x1p-7f, node.exponent[axis] - 127); };
  return {margin(0), margin(1), margin(2)};
}

// A padding many times as large would pass the test above and cost a traversal its speed.
TEST_P(DeviceSlabs, MissWhatIsClearlyBeside) {
  const std::vector<GridCase> cases = cases_of(GetParam().factor, 12000, 7);
  const Array<Answer> answers = answers_to(cases);
  for (std::size_t i = 0; i < cases.size() && !HasFailure(); ++i) {
    const auto& [node, slot, child, scene, ray] = cases[i];
    const Vec3 margin = margin_of(scene);
    const Aabb decoded = decode_box(node, slot);
    EXPECT_TRUE(!answers[i].box || host_meets(ray, scene, widened(child, margin)))
        << "seed 7, case " << i;
    EXPECT_TRUE(!answers[i].grid ||
                host_meets(ray, scene, widened(decoded, margin + margin_of(node))))
        << "seed 7, case " << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Scales, DeviceSlabs, testing::ValuesIn(test::kGridScales),
                         [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace treelet::cuda
