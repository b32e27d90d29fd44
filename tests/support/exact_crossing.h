#pragma once

#include <treelet/core/ray.h>
#include <treelet/mesh/mesh.h>

#include "support/exact_ray.h"

namespace treelet::test {

/// Whether a ray displaced by (e, e^2) crosses the triangle, for one certain e that is smaller than
/// any two floats tell apart, and where the ray itself meets it. Nothing symbolic: the oracle of
/// the fill rule.
struct ExactCrossing {
  bool crosses;
  Fraction t;
};
ExactCrossing exact_crossing(const Ray& ray, const Triangle& triangle);

/// How often the ray crosses the mesh at t >= 0.
int count_exact_crossings(const Ray& ray, const Mesh& mesh);

}  // namespace treelet::test
