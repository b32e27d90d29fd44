#pragma once

#include <ostream>

#include <treelet/core/aabb.h>
#include <treelet/core/ray.h>

#include "support/random.h"

// Boxes and rays that graze them: what slab tests are tested with.

namespace treelet::test {

/// A box in [-1, 2]^3 of any size, flat along an axis as often as not.
Aabb random_box(Random& random);

/// A ray that grazes the box or passes it closely, along an axis now and then, with finite limits
/// near where it passes.
Ray random_ray_at(Random& random, const Aabb& box);

struct Scale {
  const char* name;  ///< letters: fit for the name of a parametrised test
  float factor;
};
std::ostream& operator<<(std::ostream& out, const Scale& scale);

Aabb scaled(const Aabb& box, float factor);
/// Its t means the same.
Ray scaled(const Ray& ray, float factor);

}  // namespace treelet::test
