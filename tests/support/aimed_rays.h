#pragma once

#include <cstdint>
#include <vector>

#include <treelet/core/ray.h>

#include "support/meshes.h"
#include "support/random.h"
#include "support/ray_cases.h"

namespace treelet::test {

/// A mesh of random triangles, and for each a ray that is aimed at it.
struct AimedRays {
  OwnedMesh mesh;
  std::vector<Ray> rays;

  AimedRays(Aim aim, int count, std::uint64_t seed) {
    Random random(seed);
    for (int i = 0; i < count; ++i) {
      const auto& [triangle, ray] = random_case(random, aim);
      mesh.add(triangle.p0, triangle.p1, triangle.p2);
      rays.push_back(ray);
    }
  }
};

}  // namespace treelet::test
