#pragma once

#include <cstddef>

#include <treelet/layout/bvh2.h>
#include <treelet/layout/bvh8.h>
#include <treelet/layout/cwbvh.h>
#include <treelet/tree/sah.h>

namespace treelet {

/// End-point overlap [AilaKarrasLaine2013 s4]: how much of the surface lies inside nodes that it
/// does not belong to. Rays end on surfaces, and there they pay for every such node:
///
///     EPO = sum over nodes n of C(n) * area(surface outside the subtree of n, inside its box)
///           / area(surface)
///
/// with C = Ci for internal nodes and Ct * N for leaves. 0 means that no end point ever sees a
/// foreign node. max_triangles > 0 estimates it from about that many triangles, evenly spread.
/// A wide node counts once, like a binary one, so compare within one layout. The boxes of a cwbvh
/// are those that its planes bound.
double compute_epo(const Bvh2& bvh, const SahModel& sah, std::size_t max_triangles = 0);
double compute_epo(const Bvh8& bvh, const SahModel& sah, std::size_t max_triangles = 0);
double compute_epo(const Cwbvh& bvh, const SahModel& sah, std::size_t max_triangles = 0);

}  // namespace treelet
